"""One run of a campaign, in a process of its own, so that chaos can kill its launcher.

Run as `python -m runtime.campaign.single_run RUN`; the folder RUN holds the resolved deployment.
"""

import sys
from pathlib import Path

from runtime.config.deployment import load
from runtime.errors import RunError
from runtime.launching.launcher import Launcher
from runtime.results.finishing import close


def main(run: Path) -> int:
    """Launch the run, and write its `summary.json`."""
    deployment = load(run / "deployment.yaml")
    try:
        outcome = Launcher(deployment, run, lambda: None).go()
    except RunError as error:
        print(error)
        return 1
    return close(deployment, run, outcome, plot=False)[0].code


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
