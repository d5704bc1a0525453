"""What the laws are pure functions over: the functions of numpy, or the same of plain floats.

An agent in its process decides for one robot, and floats compute ten times as fast as arrays
without dimensions; in a study it decides for thousands at once. A law takes the namespace as its
first argument, as in the Python array API standard, and hands numbers to its functions.
"""

import math
from types import ModuleType
from typing import Any

import numpy as np

from agents.agent import Array

Number = Any
"""A float of one robot, or an array (...) of a batch of them."""
Vector = tuple[Number, Number, Number]
"""The components x, y, z of a vector, or of one for each robot of a batch."""
Namespace = Any
"""`ONE` or `MANY`."""
MANY: Namespace = np


def _clip(value: float, least: float, most: float) -> float:
    value = value if value > least else least
    return value if value < most else most


ONE: Namespace = ModuleType("one")
ONE.__dict__.update(
    abs=abs,
    atan2=math.atan2,
    clip=_clip,
    copysign=math.copysign,
    cos=math.cos,
    sin=math.sin,
    sqrt=math.sqrt,
    any=bool,
    maximum=lambda a, b: a if a > b else b,
    minimum=lambda a, b: a if a < b else b,
    where=lambda condition, yes, no: yes if condition else no,
)
"""As of `numpy`, for plain floats: a module too, for Python finds the functions of one faster."""


def namespace_of(vectors: Array) -> Namespace:
    """Return the namespace for vectors (..., n): `ONE` for a lone one."""
    return ONE if vectors.ndim == 1 else MANY


def components(vectors: Array) -> tuple[Number, ...]:
    """Return the n components (...) of vectors (..., n): floats of a lone one."""
    if vectors.ndim == 1:
        return tuple(vectors.tolist())
    return tuple([vectors[..., i] for i in range(vectors.shape[-1])])
