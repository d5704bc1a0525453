"""Quantities with units."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant.errors import MsmaError
from plant.units import Unit, UnitError, parse_quantity


@pytest.mark.parametrize(
    ("text", "unit", "si"),
    [
        ("60 ms", "s", 0.06),
        ("60ms", "s", 0.06),
        ("2 min", "s", 120.0),
        ("7.28 cm/s", "m/s", 0.0728),
        ("50 deg/s", "rad/s", math.radians(50)),
        ("-90deg", "rad", -math.pi / 2),
        ("45°", "rad", math.pi / 4),
        ("4 rad/s^2", "rad/s2", 4.0),
        ("50 cm/s²", "m/s2", 0.5),
        ("1 kHz", "Hz", 1000.0),
        ("50 %", "1", 0.5),
        ("1e-3 m", "m", 1e-3),
        (" .5 ", "m", 0.5),
        ("5µs", "s", 5e-6),
    ],
)
def test_a_quantity_is_given_in_si(text: str, unit: Unit, si: float) -> None:
    assert parse_quantity(text, unit) == pytest.approx(si, rel=1e-12)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_number_without_a_unit_is_si_already(number: float) -> None:
    assert parse_quantity(number, "m") == number
    assert parse_quantity(repr(number), "m") == number


def test_a_unit_of_another_kind_is_refused_with_an_example_of_the_right_one() -> None:
    with pytest.raises(UnitError) as error:
        parse_quantity("60 deg", "s")
    assert str(error.value) == "60 deg is an angle; a time is wanted, such as 60 ms or 0.06 s"


def test_an_unknown_unit_is_named() -> None:
    with pytest.raises(UnitError, match="there is no unit 'furlong'; a length is wanted"):
        parse_quantity("3 furlong", "m")


@pytest.mark.parametrize(
    "value", [math.nan, math.inf, "nan", "1e999", "", "fast", "1 2", True, None, [1.0], 10**400]
)
def test_what_is_no_finite_number_is_refused(value: object) -> None:
    with pytest.raises(UnitError, match="a time"):
        parse_quantity(value, "s")  # type: ignore[arg-type]  # the caller read it from a file


def test_a_unit_error_is_an_msma_error_and_a_value_error() -> None:
    assert issubclass(UnitError, MsmaError)
    assert issubclass(UnitError, ValueError)
