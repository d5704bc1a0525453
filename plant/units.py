"""Quantities as people write them ("60 ms", "7.28 cm/s"), turned into plain SI numbers."""

import math
import re
from typing import Literal, NamedTuple

from plant.errors import MsmaError

Unit = Literal["s", "m", "rad", "rad or m", "m/s", "rad/s", "m/s2", "rad/s2", "Hz", "kg", "N", "1"]


class UnitError(MsmaError, ValueError):
    """A quantity that is no number, is not finite, or is of another kind than the one wanted."""


class _Kind(NamedTuple):
    """One kind of quantity: its name, an example, and its units."""

    name: str
    example: str
    units: dict[str, float]  # how much of the SI unit each is


_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_ANGLES = {"rad": 1.0, "deg": math.pi / 180.0}


def _per(numerators: dict[str, float], divisor: str) -> dict[str, float]:
    return {f"{unit}/{divisor}": factor for unit, factor in numerators.items()}


_KINDS: dict[Unit, _Kind] = {
    "s": _Kind(
        "a time", "60 ms or 0.06 s", {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
    ),
    "m": _Kind("a length", "3 mm or 0.003 m", _LENGTHS),
    "rad": _Kind("an angle", "60 deg or 1.05 rad", _ANGLES),
    "rad or m": _Kind("an angle or a length", "60 deg or 30 cm", _ANGLES | _LENGTHS),
    "m/s": _Kind("a speed", "7.28 cm/s or 0.0728 m/s", _per(_LENGTHS, "s")),
    "rad/s": _Kind("an angular speed", "50 deg/s or 0.87 rad/s", _per(_ANGLES, "s")),
    "m/s2": _Kind("an acceleration", "0.5 m/s2", _per(_LENGTHS, "s2")),
    "rad/s2": _Kind("an angular acceleration", "4 rad/s2", _per(_ANGLES, "s2")),
    "Hz": _Kind("a frequency", "16.7 Hz or 1 kHz", {"Hz": 1.0, "kHz": 1e3}),
    "kg": _Kind("a mass", "300 g or 0.3 kg", {"kg": 1.0, "g": 1e-3}),
    "N": _Kind("a force", "20 N", {"N": 1.0}),
    "1": _Kind("a plain number", "0.5 or 50 %", {"1": 1.0, "%": 1e-2}),
}
_SPELLINGS = {"²": "2", "^2": "2", "µ": "u", "μ": "u", "°": "deg"}
_WRITTEN: dict[Unit, tuple[str, float]] = {  # the unit people write, and how much of it one SI is
    "rad": ("deg", 180.0 / math.pi),
    "m": ("mm", 1e3),
    "s": ("ms", 1e3),
    "kg": ("kg", 1.0),
    "N": ("N", 1.0),
    "1": ("", 1.0),
}
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)


def parse_quantity(value: float | int | str, unit: Unit) -> float:
    """Return a quantity as a number.

    Args:
        value: As people write it; a number without a unit is in SI.
        unit: The SI unit of the result.

    Raises:
        UnitError: The value is no finite number, or its unit is of another kind. The message says
            which kind was given, which is wanted, and how one is written.
    """
    wanted = _KINDS[unit]
    if isinstance(value, bool) or not isinstance(value, float | int | str):
        raise UnitError(f"{value!r} is not {wanted.name}; write one such as {wanted.example}")
    if not isinstance(value, str):
        return _finite(value, 1.0, value, wanted)
    match = _QUANTITY.fullmatch(value)
    if match is None:
        raise UnitError(f"{value!r} is not {wanted.name}; write one such as {wanted.example}")
    number, given = match.groups()
    for spelling, plain in _SPELLINGS.items():
        given = given.replace(spelling, plain)
    factor = wanted.units.get(given, 1.0 if not given else None)
    if factor is None:
        raise UnitError(_complaint(value, given, wanted))
    return _finite(float(number), factor, value, wanted)


def written(value: float, unit: Unit) -> str:
    """Return a quantity as people write it, if it reads back exactly so; else in SI."""
    name, per_si = _WRITTEN[unit]
    text = f"{value * per_si:.10g}{name}"
    if not math.isfinite(value) or parse_quantity(text, unit) == value:
        return text
    return f"{value!r}{unit if unit != '1' else ''}"


def _finite(number: float, factor: float, value: object, wanted: _Kind) -> float:
    try:
        result = float(number) * factor
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise UnitError(
            f"{value!r} is not finite; {wanted.name} is wanted, such as {wanted.example}"
        )
    return result


def _complaint(value: str, given: str, wanted: _Kind) -> str:
    want = f"{wanted.name} is wanted, such as {wanted.example}"
    for unit, kind in _KINDS.items():
        if given in kind.units and unit != "rad or m":
            return f"{value.strip()} is {kind.name}; {want}"
    return f"{value.strip()!r}: there is no unit {given!r}; {want}"
