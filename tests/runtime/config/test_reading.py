import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
import yaml

from runtime.config.kinds import File, Kind, Quantity, Scope, Text, Whole
from runtime.config.reading import Derived, Field, Rest, kind_of, parameters_of
from runtime.config.tree import ConfigError, Location, YamlNode, parse

START = Location("x.yaml", Path("/"), 1, 1)


def read(text: str, annotation: Any) -> Any:
    return kind_of(annotation).read(parse(text, START), {})


def refused(text: str, annotation: Any) -> str:
    with pytest.raises(ConfigError) as caught:
        read(text, annotation)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "annotation", "value"),
    [
        ("3", float, 3.0),
        ("1e-3", float, 0.001),
        (".5", float, 0.5),
        ("50 %", float, 0.5),
        ("60 ms", Annotated[float, "s"], 0.06),
        ("60ms", Annotated[float, "s"], 0.06),
        ("'60 ms'", Annotated[float, "s"], 0.06),
        ("0.06", Annotated[float, "s"], 0.06),
        ("180 deg", Annotated[float, "rad"], math.pi),
        ("-7", int, -7),
        ("007", int, 7),
        ("yes", bool, True),
        ("True", bool, True),
        ("off", bool, False),
        ("on", str, "on"),
        ("1e-3", str, "1e-3"),
        ("''", str, ""),
        ("fixed-step", Literal["line", "fixed-step"], "fixed-step"),
        ("2", Literal[1, 2], 2),
        ("[1 cm, 2]", tuple[Annotated[float, "m"], int], (0.01, 2)),
        ("[1 cm, 2]", Annotated[tuple[float, ...], "m"], (0.01, 2.0)),
        ("[[1], []]", tuple[tuple[int, ...], ...], ((1,), ())),
        ("~", int | None, None),
        ("4", int | None, 4),
        ("1 cm", Annotated[float, "m"] | None, 0.01),
        ("1 cm", Annotated[float | None, "m"], 0.01),
        ("/dev/null", Path, Path("/dev/null")),
        ("a/../b", Annotated[Path, File("runs", output=True)], Path.cwd() / "b"),
    ],
)
def test_a_value_is_read_as_it_is_declared_and_again_as_it_is_written(
    text: str, annotation: Any, value: Any
) -> None:
    assert read(text, annotation) == value
    kind = kind_of(annotation)
    assert read(yaml.safe_dump(kind.write(value)), annotation) == value


@pytest.mark.parametrize(
    ("text", "annotation", "says"),
    [
        ("60 deg", Annotated[float, "s"], "60 deg is an angle; a time is wanted, such as 60 ms"),
        ("nan", float, "'nan' is not a plain number; write one such as 0.5 or 50 %"),
        ("1:30", float, "'1:30': there is no unit ':30'; a plain number is wanted"),
        ("yes", float, "'yes' is not a plain number"),
        ("0x10", int, "'0x10' is not a whole number, such as 1"),
        ("1.0", int, "'1.0' is not a whole number, such as 1"),
        ("9" * 5000, int, "'999"),
        ("[1]", int, "'[1]' is not a whole number, such as 1"),
        ("1", bool, "'1' is not a valid choice; valid are true, yes, on, false, no, off"),
        ("~", str, "'' is not text, such as text"),
        ("{a: 1}", str, "'{a: 1}' is not text, such as text"),
        (
            "fixed_step",
            Literal["line", "fixed-step"],
            "'fixed_step' is not a valid choice; did you mean",
        ),
        ("3", tuple[int, ...], "'3' is not a list, such as [1]"),
        ("[1, 2]", tuple[int, int, int], "expected 3 values, got 2, such as [1, 1, 1]"),
        ("0", Annotated[int, Whole("5", above=0)], "0 must be positive, such as 5"),
        ("9", Annotated[int, Whole("5", most=8)], "9 must be at most 8, such as 5"),
        (
            "-1 mm",
            Annotated[float, Quantity("5 m", "m", least=1)],
            "-1 mm must be at least 1 m, such as 5 m",
        ),
        ("B", Annotated[str, Text("b", "a letter", "[a-z]")], "'B' is not a letter, such as b"),
        ("nowhere", Path, "there is no file /nowhere"),
        ("~nobody-of-that-name/x", Path, "there is no file /~nobody-of-that-name/x"),
        ("x" * 999, Path, "there is no file /xxx"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_with_what_would(
    text: str, annotation: Any, says: str
) -> None:
    assert refused(text, annotation).startswith(f"x.yaml:1:1: {says}")


@pytest.mark.parametrize("annotation", [object, dict[str, int], int | str, "float", list[int]])
def test_an_annotation_that_no_file_can_say_is_refused(annotation: Any) -> None:
    with pytest.raises(TypeError, match="a file cannot hold"):
        kind_of(annotation)


class Colour:
    def __init__(self, code: str) -> None:
        self.code = code

    def __str__(self) -> str:
        return self.code


class Hex(Kind, frozen=True):
    def read(self, node: YamlNode, scope: Scope) -> Colour:
        if not node.text.startswith("#"):
            raise node.error(f"{node.text} has no #")
        return Colour(node.text)


OWN_KIND = Annotated[Colour, Hex("#ff0000")]


@dataclass(frozen=True, kw_only=True)
class Wheel:
    size: Annotated[float, Quantity("10 cm", "m", above=0)]
    spokes: int = 5

    def check(self, node: YamlNode, scope: Scope) -> None:
        if self.spokes > scope["most"]:
            raise node.find("spokes").error(f"{self.spokes} spokes, of {scope['most']} at most")


LOAD = [Field("load", kind_of(float), MISSING)]


@dataclass(frozen=True, kw_only=True)
class Cart:
    most: int = 9
    double: Annotated[int, Derived(lambda scope: 2 * scope["most"])]
    class_: str
    wheels: tuple[Wheel, ...] = ()
    spare: Wheel | None = None
    rest: Annotated[
        Mapping[str, Any],
        Rest(lambda scope: None if scope["class_"] == "any" else LOAD),
    ]


def test_a_mapping_becomes_a_dataclass_with_its_defaults() -> None:
    cart = read("{class: a, load: 3, most: 6, wheels: [{size: 5 cm}]}", Cart)
    wheels = (Wheel(size=0.05),)
    assert cart == Cart(class_="a", most=6, double=12, wheels=wheels, rest={"load": 3.0})


def test_a_dataclass_is_written_with_its_defaults() -> None:
    cart = read("{class: a, load: 3, wheels: [{size: 5 cm}]}", Cart)
    assert kind_of(Cart).write(cart) == {
        "most": 9,
        "double": 18,
        "class": "a",
        "wheels": [{"size": "0.05 m", "spokes": 5}],
        "load": 3.0,
    }


def test_what_is_not_looked_into_is_kept_as_written() -> None:
    cart = read("{class: any, what: [1, ~]}", Cart)
    assert cart.rest == {"what": ["1", None]}
    assert kind_of(Cart).write(cart)["what"] == ["1", None]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{load: 1}", "1:1: the key 'class' is missing, such as class: text"),
        ("{class: a}", "1:1: the key 'load' is missing, such as load: 0"),
        ("{clas: a}", "1:2: unknown key 'clas'; did you mean 'class'? valid are most, double, "),
        ("{class: a, laod: 1}", "1:12: unknown key 'laod'; did you mean 'load'? valid are most, "),
        ("{class: a, load: 1, spare: {size: 1, x: 1}}", "1:38: spare: unknown key 'x'; valid are"),
        ("{class: a, load: 1, spare: {}}", "1:28: spare: the key 'size' is missing, such as size:"),
        ("{class: a, load: 1, spare: 3}", "1:28: spare: '3' is not a mapping, such as {size: 10"),
        (
            "{class: a, load: 1, most: 4, wheels: [{size: 1}]}",
            "1:39: wheels.0: 5 spokes, of 4 at most",
        ),
    ],
)
def test_a_mapping_that_does_not_fit_is_refused_at_the_key_or_value(text: str, says: str) -> None:
    assert refused(text, Cart).startswith(f"x.yaml:{says}")


def test_a_value_may_be_of_a_kind_of_its_own() -> None:
    kind = kind_of(OWN_KIND)
    assert kind.write(read("'#123456'", OWN_KIND)) == "#123456"
    assert refused("red", OWN_KIND) == "x.yaml:1:1: red has no #"
    assert kind.such_as == "#ff0000"


class Machine:
    def __init__(
        self, body: object, plan: int = 3, *, speed: "Annotated[float, 'm/s']", friend: object = 1
    ) -> None:
        pass


def test_of_a_class_the_keyword_parameters_that_a_file_can_hold_are_given() -> None:
    assert [(field.name, field.kind) for field in parameters_of(Machine)] == [
        ("speed", kind_of(Annotated[float, "m/s"]))
    ]


class Untyped:
    def __init__(self, *, speed) -> None:  # type: ignore[no-untyped-def]  # this is the point
        pass


class Misnamed:
    def __init__(self, *, speed: "Sped") -> None:  # type: ignore[name-defined]  # noqa: F821
        pass


def test_a_class_whose_parameters_have_no_usable_type_is_refused() -> None:
    with pytest.raises(TypeError, match="its parameter speed has no type that a file can hold"):
        parameters_of(Untyped)
    with pytest.raises(NameError, match="Sped"):
        parameters_of(Misnamed)
