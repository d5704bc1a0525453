"""Environments of other systems, each made once from PyPI and kept in the user's cache folder."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from zlib import crc32

from bench.bench import BenchError

_MOST = 600.0  # [s] for pip
_READY = "versions.json"


def cache() -> Path:
    """Return the folder in which environments are kept."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "msma" / "bench"


def environment(
    name: str, requirements: tuple[str, ...], say: Callable[[str], None], folder: Path | None = None
) -> tuple[Path, Mapping[str, str]]:
    """Return the Python of an environment with these requirements, and its packages' versions.

    It is made, which `say` is told, unless it is there. `BenchError` if PyPI does not give it.
    """
    wanted = json.dumps([sys.version_info[:3], requirements])
    root = (folder or cache()) / f"{name}-{crc32(wanted.encode()):08x}"
    python = root / "bin" / "python"
    if not (root / _READY).is_file():
        say(f"makes an environment with {', '.join(requirements)} in {root}")
        _make(root, python, requirements)
    found: Mapping[str, str] = json.loads((root / _READY).read_text(encoding="utf-8"))
    return python, found


def _make(root: Path, python: Path, requirements: tuple[str, ...]) -> None:
    shutil.rmtree(root, ignore_errors=True)  # what an attempt that was broken off has left
    pip = (str(python), "-m", "pip", "--disable-pip-version-check")
    run(root, sys.executable, "-m", "venv", str(root))
    run(root, *pip, "install", "--quiet", *requirements)
    listed = json.loads(run(root, *pip, "list", "--format", "json"))
    versions = {package["name"]: package["version"] for package in listed}
    (root / _READY).write_text(json.dumps(versions), encoding="utf-8")


def run(root: Path, *command: str) -> str:
    """Return what a command prints; `BenchError` says why the environment `root` is not made."""
    env = {key: text for key, text in os.environ.items() if key != "PYTHONPATH"}
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, env=env, timeout=_MOST, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BenchError(f"{root.name} cannot be made: {error}") from error
    if done.returncode:
        why = (done.stderr.strip() or done.stdout.strip() or "it said nothing").splitlines()
        raise BenchError(f"{root.name} cannot be made: {' '.join(command[-3:])}: {why[-1]}")
    return done.stdout
