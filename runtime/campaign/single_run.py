"""One run of a campaign, in a process of its own: it may be killed, as any launcher may.

Run as `python -m runtime.campaign.single_run RUN`, a folder with the deployment as resolved.
"""

import sys
from pathlib import Path

from runtime.config.deployment import load
from runtime.errors import RunError
from runtime.launching.launcher import Launcher
from runtime.results.finishing import conclude
from runtime.watching.watcher import View


class _Silence:
    """A screen that shows nothing."""

    def happened(self, t: float, text: str) -> None:
        """Nobody looks."""

    def show(self, view: View) -> None:
        """Nobody looks."""

    def close(self) -> None:
        """There is nothing to do."""


def main(run: Path) -> int:
    """Launch, and leave `summary.json` in the folder."""
    deployment = load(run / "deployment.yaml")
    try:
        course = Launcher(deployment, run, _Silence).go()
    except RunError as error:
        print(error)
        return 1
    return conclude(deployment, run, course)[0].code


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
