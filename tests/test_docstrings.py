"""The docstrings are in Google style, and names are made of the field's words."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("bench", "nodes", "plant", "runtime", "studies")
FILES = sorted(file for folder in FOLDERS for file in (ROOT / folder).rglob("*.py"))
"""All but `agents/`, which is written anew after this."""
AGENTS = sorted((ROOT / "agents").rglob("*.py"))

SECTIONS = ("Args", "Attributes", "Example", "Examples", "Note", "Raises", "Returns", "Yields")
HEADER = re.compile(rf"^({'|'.join(SECTIONS)}):$")
INLINE_SECTION = re.compile(r"^(Args|Attributes|Raises|Returns|Yields): ?\S")
LISTED_NAME = re.compile(r"^[a-z_][a-z_0-9]*(, [a-z_][a-z_0-9]*)*: ")
ENTRY = re.compile(r"^    (\*{0,2}\w+): ")
HOME_MADE = re.compile(
    "aftermath|crew|ears?|farewell|havoc|hearing|heirs?|lots|nursery|orders|tally|teller|told|"
    "trays?|verdict|voices?"
)

Documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def documented(file: Path) -> Iterator[tuple[Documented, str]]:
    """Yield what has a docstring, with that docstring."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, Documented) and (text := ast.get_docstring(node)):
            yield node, text


def outside_sections(text: str) -> Iterator[str]:
    """Yield the first lines of a docstring's paragraphs outside of sections."""
    inside, first = False, True
    for line in text.splitlines():
        if HEADER.match(line):
            inside = True
        elif line and not line.startswith(" "):
            inside = False
        if first and line and not inside:
            yield line
        first = not line


def entries(text: str, section: str) -> list[str]:
    """Return the names that a section of a docstring lists."""
    _, _, rest = text.partition(f"\n{section}:\n")
    block = re.split(r"\n(?=\S)", rest)[0]
    return [found[1].lstrip("*") for line in block.splitlines() if (found := ENTRY.match(line))]


def parameters(node: Documented) -> set[str]:
    """Return the parameters of a function, or of a class's `__init__`; of others none."""
    if isinstance(node, ast.ClassDef):
        makers = [f for f in node.body if isinstance(f, ast.FunctionDef) and f.name == "__init__"]
        return set().union(*map(parameters, makers))
    if isinstance(node, ast.Module):
        return set()
    every = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    every += [one for one in (node.args.vararg, node.args.kwarg) if one is not None]
    return {one.arg for one in every}


def attributes(node: ast.ClassDef) -> set[str]:
    """Return the attributes that a class declares or assigns, and its properties."""
    names = {f.name for f in node.body if isinstance(f, ast.FunctionDef)}
    for inner in ast.walk(node):
        if isinstance(inner, ast.AnnAssign | ast.Assign):
            for target in inner.targets if isinstance(inner, ast.Assign) else [inner.target]:
                for name in ast.walk(target):
                    names |= {name.id} if isinstance(name, ast.Name) else set()
                    names |= {name.attr} if isinstance(name, ast.Attribute) else set()
    return names


def identifiers(file: Path) -> Iterator[tuple[int, str]]:
    """Yield line and name of all that a file defines or imports."""
    yield 0, file.stem
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.lineno, node.name
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.alias):
            yield node.lineno, node.name
        elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id if isinstance(node, ast.Name) else node.attr


def words(name: str) -> set[str]:
    """Return the words of a name in snake case or camel case."""
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name)}


def classes(file: Path) -> Iterator[ast.ClassDef]:
    return (
        node for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.ClassDef)
    )


def folder(file: Path) -> str:
    return file.relative_to(ROOT).parts[0]


CLASSES = {
    (where, node.name): (folder(file), node)
    for file in [*AGENTS, *FILES]
    for node in classes(file)
    for where in ("anywhere", folder(file))  # of classes of one name the nearest is meant
}


def method_docstrings(node: ast.ClassDef, where: str) -> dict[str, str | None]:
    """Return the docstrings of a class's own and inherited methods, by their names."""
    inherited: dict[str, str | None] = {}
    for base in reversed(node.bases):
        name = ast.unparse(base).partition("[")[0].rpartition(".")[2]
        found = CLASSES.get((where, name)) or CLASSES.get(("anywhere", name))
        inherited |= method_docstrings(found[1], found[0]) if found else {}
    methods = [inner for inner in node.body if isinstance(inner, ast.FunctionDef)]
    return inherited | {f.name: ast.get_docstring(f) or inherited.get(f.name) for f in methods}


def each(file: Path) -> str:
    return str(file.relative_to(ROOT))


@pytest.mark.parametrize("file", [*AGENTS, *FILES], ids=each)
def test_a_public_method_has_a_docstring_or_inherits_one(file: Path) -> None:
    for node in classes(file):
        found = {} if node.name.startswith("_") else method_docstrings(node, folder(file))
        missing = [name for name, text in found.items() if not text and not name.startswith("_")]
        assert not missing, f"{each(file)}:{node.lineno}: {missing}"


@pytest.mark.parametrize("file", FILES, ids=each)
def test_what_a_docstring_lists_is_in_a_section(file: Path) -> None:
    for node, text in documented(file):
        lines = list(outside_sections(text))
        listed = [line for line in lines[1:] if LISTED_NAME.match(line)]
        inline = [line for line in text.splitlines() if INLINE_SECTION.match(line)]
        line = getattr(node, "lineno", 1)
        assert not listed + inline, f"{each(file)}:{line} lists names without a section"


@pytest.mark.parametrize("file", FILES, ids=each)
def test_what_a_section_lists_is_there(file: Path) -> None:
    for node, text in documented(file):
        line = getattr(node, "lineno", 1)
        unknown = set(entries(text, "Args")) - parameters(node)
        if isinstance(node, ast.ClassDef):
            unknown |= set(entries(text, "Attributes")) - attributes(node)
        assert not unknown, f"{each(file)}:{line} documents {unknown}, which it does not have"


@pytest.mark.parametrize("file", FILES, ids=each)
def test_names_are_made_of_the_field_s_words(file: Path) -> None:
    for line, name in identifiers(file):
        home_made = set(filter(HOME_MADE.fullmatch, words(name)))
        assert not home_made, f"{each(file)}:{line}: {name}"
