"""docs/law.md lists every constant of agents/; `python -m tests.agents.test_law_docs` writes it.

A constant is a name in capitals at the top of a module or class, with a docstring below it that
begins with its unit in brackets and says what it means and where it comes from. Defaults of
parameters are constants too. Any other number in the code counts as one that is not declared, but
for those of formulas and shapes (0 to 4, a half) and those that keep a division from failing.
"""

import ast
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parent.parent.parent
PAGE = ROOT / "docs" / "law.md"
BEGIN, END = "<!-- generated from agents/ -->\n", "<!-- end -->"
MOST = 45
FORMULAS = {0, 1, 2, 3, 4, 0.5}
TINY = 1e-5


class Constant(NamedTuple):
    """A declared constant, or the default of a parameter.

    Attributes:
        file: Name of its module.
        name: Its name, `Class.NAME` within a class; of a default `Class(parameter)`.
        value: As in the code.
        text: Its docstring on one line; of a default its unit alone.
        numbers: How many numbers it is.
    """

    file: str
    name: str
    value: str
    text: str
    numbers: int

    @property
    def unit(self) -> str:
        """The unit in brackets; nothing if there is none."""
        return self.text[1 : self.text.index("]")] if self.text.startswith("[") else ""

    @property
    def meaning(self) -> str:
        """What it means, and its origin."""
        return self.text.split("]", 1)[1].strip() if self.text.startswith("[") else self.text


def files():
    return sorted((ROOT / "agents").glob("*.py"))


def numbers(node):
    """The numbers in an expression that belong to no formula."""
    for inner in ast.walk(node):
        if isinstance(inner, ast.Constant) and type(inner.value) in (int, float):
            yield inner


def declarations(tree, prefix=""):
    """Node, name, expression and docstring of each constant at the top of a module or class."""
    for node, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        if isinstance(node, ast.ClassDef):
            yield from declarations(node, f"{node.name}.")
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            target, value = node.targets[0], node.value
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            target, value = node.target, node.value
        else:
            continue
        if not isinstance(target, ast.Name) or not target.id.lstrip("_").isupper():
            continue
        doc = ""
        if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
            doc = " ".join(str(after.value.value).split())
        yield node, prefix + target.id, value, doc


def is_number(value):
    """Whether an expression is a number, or a row of numbers."""
    parts = value.elts if isinstance(value, ast.Tuple) else [value]
    plain = (ast.Constant, ast.UnaryOp, ast.BinOp, ast.operator, ast.unaryop, ast.expr_context)
    named = (ast.Attribute, ast.Name, ast.Call)
    return any(number.value != 0 for number in numbers(value)) and all(
        isinstance(node, plain) or (isinstance(node, named) and _is_of_mathematics(node))
        for part in parts
        for node in ast.walk(part)
    )


def _is_of_mathematics(node):
    name = ast.unparse(node.func if isinstance(node, ast.Call) else node)
    return name in ("np", "np.pi", "math", "math.pi", "np.deg2rad")


def declared():
    """Every declared constant."""
    for file in files():
        for _, name, value, doc in declarations(ast.parse(file.read_text())):
            if is_number(value):
                count = len(value.elts) if isinstance(value, ast.Tuple) else 1
                yield Constant(file.name, name, ast.unparse(value), doc, count)


def defaults():
    """Every default of a parameter that is a number other than 0 and 1."""
    for file in files():
        for node in ast.walk(ast.parse(file.read_text())):
            if not isinstance(node, ast.ClassDef):
                continue
            for inner in node.body:
                if isinstance(inner, ast.FunctionDef):
                    yield from _defaults_of(file, node.name, inner)
                elif isinstance(inner, ast.AnnAssign) and _is_field(inner):
                    name = f"{node.name}({inner.target.id})"
                    unit = f"[{_unit_of(inner.annotation)}]"
                    yield Constant(file.name, name, ast.unparse(inner.value), unit, 1)


def _is_field(node):
    """Whether it is a field of a class, with a number other than 0 and 1 for its default."""
    if node.value is None or node.target.id.lstrip("_").isupper():
        return False
    return is_number(node.value) and any(n.value not in (0, 1) for n in numbers(node.value))


def _unit_of(annotation):
    if isinstance(annotation, ast.Subscript) and "Annotated" in ast.unparse(annotation):
        return annotation.slice.elts[1].value
    return ""


def _defaults_of(file, owner, function):
    args = function.args
    pairs = [*zip(args.args[-len(args.defaults) :], args.defaults, strict=False)]
    pairs += zip(args.kwonlyargs, args.kw_defaults, strict=True)
    for arg, default in pairs:
        if default is None or all(n.value in (0, 1) for n in numbers(default)):
            continue
        name, unit = f"{owner}({arg.arg})", f"[{_unit_of(arg.annotation)}]"
        yield Constant(file.name, name, ast.unparse(default), unit, 1)


def bare():
    """File, line and value of each number that is not declared."""
    for file in files():
        tree = ast.parse(file.read_text())
        known = {
            id(inner)
            for node, _, value, _ in declarations(tree)
            if is_number(value)
            for inner in ast.walk(node)
        }
        for node in ast.walk(tree):
            every = []
            if isinstance(node, ast.arguments):
                every = [*node.defaults, *filter(None, node.kw_defaults)]
            elif isinstance(node, ast.ClassDef):
                fields = (inner for inner in node.body if isinstance(inner, ast.AnnAssign))
                every = [field.value for field in fields if _is_field(field)]
            known |= {id(inner) for one in every for inner in ast.walk(one)}
        for number in numbers(tree):
            if id(number) not in known and number.value not in FORMULAS and number.value > TINY:
                yield file.name, number.lineno, number.value


def generated():
    """Return the tables."""
    lines = ["| constant | value | unit | meaning and origin |", "| --- | --- | --- | --- |"]
    file = ""
    for each in declared():
        if each.file != file:
            file = each.file
            lines.append(f"| **[`agents/{file}`](../agents/{file})** | | | |")
        lines.append(f"| `{each.name}` | {each.value} | {each.unit or '1'} | {each.meaning} |")
    lines += ["", "| default of a parameter | value | unit |", "| --- | --- | --- |"]
    lines += [
        f"| `{each.name}` of `agents/{each.file}` | {each.value} | {each.unit or '1'} |"
        for each in defaults()
    ]
    lines += ["", f"That is {total()} numbers in all."]
    return "\n".join(lines) + "\n"


def total():
    return sum(each.numbers for each in [*declared(), *defaults()])


def page():
    before, _, rest = PAGE.read_text().partition(BEGIN)
    return before, rest.partition(END)[2]


def write():
    before, after = page()
    PAGE.write_text(before + BEGIN + generated() + END + after)


def test_the_page_lists_the_constants_that_the_code_has():
    before, after = page()
    expected = before + BEGIN + generated() + END + after
    assert PAGE.read_text() == expected, "run python -m tests.agents.test_law_docs"


@pytest.mark.parametrize(
    "constant", list(declared()), ids=lambda constant: f"{constant.file}:{constant.name}"
)
def test_each_constant_has_a_unit_a_meaning_and_an_origin(constant):
    assert constant.text.startswith("["), f"{constant.name}: its docstring begins with its unit"
    assert len(constant.meaning.split()) > 6, f"{constant.name}: what it means, and its origin"


def test_no_number_is_undeclared():
    assert list(bare()) == []


@pytest.mark.xfail(strict=True, reason="there are more numbers than there should be")
def test_there_are_few_constants():
    assert total() <= MOST


if __name__ == "__main__":
    write()
