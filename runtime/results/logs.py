"""What the processes of a run have logged."""

import json
from pathlib import Path
from typing import Any

from runtime.wire.topics import file_name


def read_log(run: Path, role: str, event: str | None = None) -> list[dict[str, Any]]:
    """Return the lines of a process's log, or those of one kind of event, which is quicker.

    A line cut short by a kill is left out.
    """
    wanted = "" if event is None else f'"event": "{event}"'
    lines = []
    try:
        with (run / f"{file_name(role)}.jsonl").open(encoding="utf-8", errors="replace") as stream:
            for line in stream:
                if wanted not in line:
                    continue
                try:
                    lines.append(json.loads(line))
                except ValueError:
                    continue
    except FileNotFoundError:
        return []
    return lines
