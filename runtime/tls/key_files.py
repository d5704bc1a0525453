"""Keys on their way to the disk of this host, or of another one of the run."""

import os
from collections.abc import Iterable, Mapping
from pathlib import Path

import yaml

from runtime.config.deployment import Deployment

KEYS = "keys"
"""The folder, in that of a run, for keys that came from another host."""


def write(folder: Path, files: Mapping[str, str]) -> None:
    """Write keys, which are PEM, to a folder, in place of old ones.

    Only their owner can read private keys at any time, and the folder, if it is made. Raises
    `OSError` if they cannot be written.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    for name, data in files.items():
        file, mode = folder / name, 0o600 if name.endswith(".key") else 0o644
        file.unlink(missing_ok=True)
        with os.fdopen(
            os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "w", encoding="ascii"
        ) as stream:
            stream.write(data)


def of_roles(deployment: Deployment, roles: Iterable[str]) -> dict[str, str]:
    """Return the files with the keys of some roles, as text; none if nobody asks for keys."""
    files: dict[str, str] = {}
    for role in dict.fromkeys(roles):
        credentials = deployment.credentials(role)
        for file in credentials.files if credentials else ():
            files[file.name] = file.read_text(encoding="ascii")
    return files


def moved(text: str) -> str:
    """Return a deployment's text that looks for its keys beside itself, where `write` put them."""
    plain = yaml.safe_load(text)
    plain["security"]["keys"] = KEYS
    moved: str = yaml.safe_dump(plain, sort_keys=False, default_flow_style=None, width=100)
    return moved
