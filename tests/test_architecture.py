"""The direction of imports, what the pure parts keep away from, and how large files are."""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
MAY_IMPORT = {
    "plant": {"plant"},
    "agents": {"agents", "plant"},
    "runtime": {"runtime", "agents", "plant"},
    "nodes": {"nodes", "runtime", "agents", "plant"},
    "studies": {"studies", "nodes", "runtime", "agents", "plant"},
    "bench": {"bench", "studies", "nodes", "runtime", "agents", "plant"},
}
OURS = {"plant", "agents", "runtime", "nodes", "studies", "bench"}
IMPURE = {"zenoh", "time", "datetime", "random", "socket", "threading", "asyncio", "subprocess"}
MOST_FILES, MOST_LINES = 15, 350


def imported(file: Path) -> set[str]:
    """What a file imports: at its top, in functions, for type checkers, and by name."""
    tree = ast.parse(file.read_text())
    spawned = {id(argument) for call in calls(tree, "spawn") for argument in call.args}
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in spawned  # what another process runs is not imported here
        ):
            names.add(node.value)
    return names


def calls(tree: ast.AST, name: str) -> Iterator[ast.Call]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name:
            yield node


def packages_imported(file: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.split(".")[0])
    return found


def module_name(file: Path, root: Path) -> str:
    return ".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__")


def import_graph(folder: Path) -> dict[str, set[str]]:
    """Which module of a folder imports which others of it."""
    files = {
        ".".join(file.relative_to(folder.parent).with_suffix("").parts).removesuffix(
            ".__init__"
        ): file
        for file in folder.rglob("*.py")
    }
    graph = {name: (imported(file) & files.keys()) - {name} for name, file in files.items()}
    if "runtime.cli" in graph:  # it puts the names of the modules together
        graph["runtime.cli"] |= {name for name in files if name.startswith("runtime.verbs.")}
    return graph


def folders(name: str) -> list[Path]:
    return sorted({file.parent for file in (ROOT / name).rglob("*.py")})


@pytest.mark.parametrize("folder", [name for name in MAY_IMPORT if (ROOT / name).is_dir()])
def test_imports_run_downwards_only(folder):
    for file in (ROOT / folder).rglob("*.py"):
        upward = (packages_imported(file) & OURS) - MAY_IMPORT[folder]
        assert not upward, f"{file.relative_to(ROOT)} imports {upward}"


@pytest.mark.parametrize("folder", ["plant", "agents"])
def test_the_pure_parts_touch_no_clock_and_no_network(folder):
    for file in (ROOT / folder).rglob("*.py"):
        touched = packages_imported(file) & IMPURE
        assert not touched, f"{file.relative_to(ROOT)} imports {touched}"


def test_no_modules_of_the_runtime_import_each_other_in_a_circle():
    try:
        TopologicalSorter(import_graph(ROOT / "runtime")).prepare()
    except CycleError as error:
        pytest.fail(f"import cycle: {' <- '.join(error.args[1])}")


def test_a_circle_is_found_even_through_a_function_and_importlib(tmp_path):
    package = tmp_path / "circle"
    package.mkdir()
    (package / "one.py").write_text("def f():\n    from circle import two\n")
    (package / "two.py").write_text("import importlib\nimportlib.import_module('circle.one')\n")
    with pytest.raises(CycleError):
        TopologicalSorter(import_graph(package)).prepare()


@pytest.mark.parametrize("folder", folders("runtime"), ids=lambda folder: folder.name)
def test_a_folder_of_the_runtime_has_few_files(folder):
    files = [file.name for file in folder.glob("*.py") if file.name != "__init__.py"]
    assert len(files) <= MOST_FILES, files


@pytest.mark.parametrize("folder", ["runtime", "nodes"])
def test_files_are_short(folder):
    lines = {file: len(file.read_text().splitlines()) for file in (ROOT / folder).rglob("*.py")}
    assert not {str(file): count for file, count in lines.items() if count > MOST_LINES}
