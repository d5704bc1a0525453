"""Arithmetic for one robot or for many: on plain floats where there is no batch, else on arrays.

An agent in its process decides for one robot, and plain floats compute ten times as fast as arrays
without dimensions; in a study it decides for thousands at once. What is written with these
functions and the usual operators does both. `Array` stands for either.
"""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from agents.agent import Array
from plant.kinematics import Parts

Mask = npt.NDArray[np.bool_]
"""Yes or no for each robot of a batch, or a plain bool where there is none."""
"""The velocity [m/s] of what stands still, for one or for many."""

_MANY = np.ndarray
# a float passes for an `Array` below by "type: ignore": `cast` is a call, and a decision has thirty


def parts(vector: Array) -> Parts:
    """Return the three parts (...) of vectors (..., 3): floats of a lone one."""
    if vector.ndim == 1:
        x, y, z = vector.tolist()
        return x, y, z
    return vector[..., 0], vector[..., 1], vector[..., 2]


def element(values: Array, index: int) -> Array:
    """Return one (...) of values (..., n): a float of a lone row."""
    if values.ndim == 1:
        return values.item(index)  # type: ignore[return-value]
    return values[..., index]


def joined(*values: Array) -> Array:
    """Return vectors (..., n) of n parts (...)."""
    vector = np.array(values)
    return vector if vector.ndim == 1 else np.moveaxis(vector, 0, -1)


def plain(value: Array) -> Array:
    """Return the value as it is, or as a float if it has no dimensions."""
    return value if value.ndim else float(value)  # type: ignore[return-value]


def alike(a: Array, b: Array) -> bool:
    """Tell whether the two are of as many robots."""
    if isinstance(a, _MANY) and isinstance(b, _MANY):
        return a.shape == b.shape
    return not isinstance(a, _MANY) and not isinstance(b, _MANY)


def moved(place: Parts, way: Parts, by: float) -> Parts:
    """Return where one comes to who goes so many times a way from a place."""
    if by == 0:  # as to a goal that stands still: a sixth of all that is worked out in a study
        return place
    return place[0] + by * way[0], place[1] + by * way[1], place[2] + by * way[2]


def between(start: Parts, end: Parts) -> Parts:
    """Return the way from a start to an end."""
    return end[0] - start[0], end[1] - start[1], end[2] - start[2]


def known(values: Array) -> bool:
    """Tell whether all values (..., n) are numbers: one that is lost is NaN."""
    values = values.T  # as the numbers of a batch lie in memory
    return not math.isnan(np.vdot(values, values))  # of a NaN and anything it is one


def _either(
    of_many: Callable[[Array], Array], of_one: Callable[[float], float]
) -> Callable[[Array], Array]:
    """Return a function of one value that takes the one for arrays or the one for a float."""

    def either(value: Array) -> Array:
        return of_many(value) if isinstance(value, _MANY) else of_one(value)

    return either


sqrt = _either(np.sqrt, math.sqrt)
"""Square root (...)."""
sin = _either(np.sin, math.sin)
"""Sine (...) of an angle [rad]."""
cos = _either(np.cos, math.cos)
"""Cosine (...) of an angle [rad]."""
arcsin = _either(np.arcsin, math.asin)
"""Angle (...) within a quarter turn of 0 [rad] of a sine."""
arccos = _either(np.arccos, math.acos)
"""Angle (...) from 0 to pi [rad] of a cosine."""
exp = _either(np.exp, math.exp)
"""e to that power (...)."""


def arctan2(y: Array, x: Array) -> Array:
    """Return the angle (...) of (x, y) [rad], within -pi to pi."""
    if isinstance(y, _MANY) or isinstance(x, _MANY):
        return np.arctan2(y, x)
    return math.atan2(y, x)


def lesser(a: Array | float, b: Array | float) -> Array:
    """Return the lesser (...) of two."""
    if isinstance(a, _MANY) or isinstance(b, _MANY):
        return np.minimum(a, b)
    return a if a < b else b  # type: ignore[return-value]


def greater(a: Array | float, b: Array | float) -> Array:
    """Return the greater (...) of two."""
    if isinstance(a, _MANY) or isinstance(b, _MANY):
        return np.maximum(a, b)
    return a if a > b else b  # type: ignore[return-value]


def within(value: Array, bound: Array | float) -> Array:
    """Return the value (...) cut to plus or minus the bound."""
    return lesser(greater(value, -bound), bound)


def where(condition: Mask, yes: Array | float, no: Array | float) -> Array:
    """Return `yes` where the condition holds, else `no`: (...)."""
    if isinstance(condition, _MANY) or isinstance(yes, _MANY) or isinstance(no, _MANY):
        return np.where(condition, yes, no)
    return yes if condition else no


def anywhere(condition: Mask | Array) -> bool:
    """Tell whether a condition holds, or a value is not 0, for any robot."""
    return bool(condition.any() if isinstance(condition, _MANY) else condition)
