"""Virtual environments of other systems, made once from PyPI and kept in the user's cache."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from zlib import crc32

from bench.bench import BenchError

_TIMEOUT = 600.0  # [s] for pip
_READY = "versions.json"


def cache() -> Path:
    """Return the folder of the environments."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "msma" / "bench"


def environment(
    name: str, requirements: tuple[str, ...], say: Callable[[str], None], folder: Path | None = None
) -> tuple[Path, Mapping[str, str]]:
    """Return the Python of an environment, and the versions of its packages.

    Makes the environment if it does not exist.

    Args:
        name: Prefix of its folder's name.
        requirements: Requirements for pip.
        say: Receives a message before the environment is made.
        folder: Folder of all environments.

    Raises:
        BenchError: It cannot be made.
    """
    wanted = json.dumps([sys.version_info[:3], requirements])
    root = (folder or cache()) / f"{name}-{crc32(wanted.encode()):08x}"
    python = root / "bin" / "python"
    if not (root / _READY).is_file():
        say(f"making an environment with {', '.join(requirements)} in {root}")
        _make(root, python, requirements)
    found: Mapping[str, str] = json.loads((root / _READY).read_text(encoding="utf-8"))
    return python, found


def _make(root: Path, python: Path, requirements: tuple[str, ...]) -> None:
    shutil.rmtree(root, ignore_errors=True)  # the remains of an interrupted attempt
    pip = (str(python), "-m", "pip", "--disable-pip-version-check")
    run(root, sys.executable, "-m", "venv", str(root))
    run(root, *pip, "install", "--quiet", *requirements)
    listed = json.loads(run(root, *pip, "list", "--format", "json"))
    versions = {package["name"]: package["version"] for package in listed}
    (root / _READY).write_text(json.dumps(versions), encoding="utf-8")


def run(root: Path, *command: str) -> str:
    """Return the output of a command.

    Raises:
        BenchError: It failed, so the environment `root` cannot be made.
    """
    env = {key: text for key, text in os.environ.items() if key != "PYTHONPATH"}
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, env=env, timeout=_TIMEOUT, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BenchError(f"{root.name} cannot be made: {error}") from error
    if done.returncode:
        why = (done.stderr.strip() or done.stdout.strip() or "it said nothing").splitlines()
        raise BenchError(f"{root.name} cannot be made: {' '.join(command[-3:])}: {why[-1]}")
    return done.stdout
