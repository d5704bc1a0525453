"""The direction of imports, and what the pure parts keep away from."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
MAY_IMPORT = {
    "plant": {"plant"},
    "agents": {"agents", "plant"},
    "runtime": {"runtime", "agents", "plant"},
    "studies": {"studies", "runtime", "agents", "plant"},
    "bench": {"bench", "studies", "runtime", "agents", "plant"},
}
OURS = {"plant", "agents", "runtime", "studies", "bench"}
IMPURE = {"zenoh", "time", "datetime", "random", "socket", "threading", "asyncio", "subprocess"}


def imported(file: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.split(".")[0])
    return names


@pytest.mark.parametrize("folder", [name for name in MAY_IMPORT if (ROOT / name).is_dir()])
def test_imports_run_downwards_only(folder):
    for file in (ROOT / folder).rglob("*.py"):
        upward = (imported(file) & OURS) - MAY_IMPORT[folder]
        assert not upward, f"{file.relative_to(ROOT)} imports {upward}"


@pytest.mark.parametrize("folder", ["plant", "agents"])
def test_the_pure_parts_touch_no_clock_and_no_network(folder):
    for file in (ROOT / folder).rglob("*.py"):
        touched = imported(file) & IMPURE
        assert not touched, f"{file.relative_to(ROOT)} imports {touched}"
