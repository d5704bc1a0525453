"""Certificate and key files, written here or copied to another host of a run."""

import os
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path

import yaml

from runtime.config.deployment import Deployment

KEYS = "keys"
"""Name of the folder in a run's folder for files that came from another host."""


def write_files(folder: Path, files: Mapping[str, str]) -> None:
    """Write certificates and private keys, PEM text by file name, replacing old ones.

    Only the owner can ever read the private keys, and the folder if it is new.
    """
    if files:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    for name, data in files.items():
        file, mode = folder / name, 0o600 if name.endswith(".key") else 0o644
        file.unlink(missing_ok=True)
        with open(file, "x", encoding="ascii", opener=partial(os.open, mode=mode)) as stream:
            stream.write(data)


def read_files(deployment: Deployment, roles: Iterable[str]) -> dict[str, str]:
    """Return the certificate and key files of roles by name; none without `security`."""
    shown = filter(None, map(deployment.credentials, dict.fromkeys(roles)))
    return {file.name: file.read_text("ascii") for one in shown for file in one.files}


def with_local_files(text: str) -> str:
    """Return a deployment's YAML that finds its certificates in the folder `KEYS` beside it."""
    plain = yaml.safe_load(text)
    plain["security"]["keys"] = KEYS
    local: str = yaml.safe_dump(plain, sort_keys=False, default_flow_style=None, width=100)
    return local
