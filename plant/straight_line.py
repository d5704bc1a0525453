"""Forward kinematics of one robot as straight-line code, written out link by link and compiled.

Most numbers of most links are 0 or 1. Products with these are left out, so that one arm, or an
array of thousands, takes less than half the time of a loop over the links.
"""

import math
from collections.abc import Callable, Collection, Sequence
from typing import Any

import numpy as np

Link = tuple[float, ...]
"""A link's x, y, z and p, as columns one after the other."""
Forward = Callable[..., tuple[Any, ...]]
_ZERO, _ONE, _MINUS_ONE = "0.0", "1.0", "-1.0"


def forward_functions(
    links: Sequence[Link], sliding: Collection[int] = ()
) -> tuple[Forward, Forward]:
    """Return functions that compute the forward kinematics of a robot: of floats, and of arrays.

    Both take x, y [m] and heading [rad] of the base, and then the joint positions [rad or m]. They
    return tuples: the grip point (3), the rotation of the hand by rows (9), a point on each
    joint's axis (n of 3), and the axes (n of 3). A number that is the same for all poses is a plain
    float.

    Args:
        links: From the base and from each joint to the next frame.
        sliding: Which links move along z instead of turning about it: i for joint i, from 1.
    """
    code = _Code()
    x, y, z = (_ONE, _ZERO, _ZERO), (_ZERO, _ONE, _ZERO), (_ZERO, _ZERO, _ONE)
    p: _Column = ("x", "y", _ZERO)
    points: list[_Column] = []
    axes: list[_Column] = []
    for i, link in enumerate(links):
        u, v = x, y
        if i in sliding:
            p = code.column(f"t{i}", (_ONE, f"a{i}"), (p, z))
        else:
            code.lines.append(f"c{i} = cos(a{i}); s{i} = sin(a{i})")
            u = code.column(f"u{i}", (f"c{i}", f"s{i}"), (x, y))  # x, turned
            v = code.column(f"v{i}", (f"c{i}", f"-s{i}"), (y, x))  # y, turned
        weights = [repr(weight + 0.0) for weight in link]  # there is a -0.0 too
        way = code.column(f"d{i}", weights[9:], (u, v, z))
        p = code.column(f"p{i}", (_ONE, _ONE), (p, way))
        x, y, z = (
            code.column(f"{name}{i}", weights[first : first + 3], (u, v, z))
            for name, first in (("x", 0), ("y", 3), ("z", 6))
        )
        points.append(p)
        axes.append(z)
    rotation = [row for rows in zip(x, y, z, strict=True) for row in rows]
    result = [_tuple(p), _tuple(rotation)]
    result += [_tuple([_tuple(each) for each in every[:-1]]) for every in (points, axes)]
    angles = [f"a{i}" for i in range(len(links))]
    return code.functions(["x", "y", *angles], result)


_Column = tuple[str, str, str]


class _Code:
    """Lines of a function, each of which gives a name to a number."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def column(self, name: str, weights: Sequence[str], columns: Sequence[_Column]) -> _Column:
        """Write down the sum of columns, each times its weight; return the names of its parts."""
        first, second, third = (
            self._number(f"{name}_{k}", _sum(weights, [column[k] for column in columns]))
            for k in range(3)
        )
        return first, second, third

    def _number(self, name: str, expression: str) -> str:
        if expression in (_ZERO, _ONE) or expression.isidentifier():
            return expression  # it has a name already
        self.lines.append(f"{name} = {expression}")
        return name

    def functions(self, arguments: Sequence[str], result: Sequence[str]) -> tuple[Forward, Forward]:
        """Return the function of floats, and that of arrays, of the same code."""
        last = f"return {_tuple(result)}"
        source = "\n    ".join([f"def forward({', '.join(arguments)}):", *self.lines, last])
        code = compile(source, "<forward kinematics>", "exec")
        of_floats: dict[str, Any] = {"cos": math.cos, "sin": math.sin}
        of_arrays: dict[str, Any] = {"cos": np.cos, "sin": np.sin}
        for scope in (of_floats, of_arrays):
            exec(code, scope)  # of our own making: there are but numbers and names of ours
        return of_floats["forward"], of_arrays["forward"]


def _tuple(items: Sequence[str]) -> str:
    return "".join(["(", *(f"{item}, " for item in items), ")"])


def _sum(weights: Sequence[str], terms: Sequence[str]) -> str:
    products = [_product(*each) for each in zip(weights, terms, strict=True)]
    total = " + ".join(each for each in products if each != _ZERO) or _ZERO
    return total.replace("+ -", "- ")  # so that nothing is negated beforehand


def _product(weight: str, term: str) -> str:
    if _ZERO in (weight, term):
        return _ZERO
    if _ONE in (weight, term):
        return term if weight == _ONE else weight
    return f"-{term}" if weight == _MINUS_ONE else f"{weight} * {term}"
