"""The kinds of value in a file: how each is read from a node, and written again."""

import math
import os
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from plant.units import Unit, UnitError, parse_quantity
from runtime.config.tree import YamlNode
from runtime.errors import valid_are

Scope = Mapping[str, Any]
"""Values read earlier, of the same and the enclosing mappings, by attribute name."""


class Range(NamedTuple):
    """Annotation: the bounds of a number.

    Attributes:
        such_as: An example within the bounds.
        above: Exclusive lower bound in SI units.
        least: Lower bound in SI units.
        most: Upper bound in SI units.
    """

    such_as: str
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf

    def check(self, value: float, node: YamlNode, unit: str = "") -> None:
        """Raise the node's error if a value is out of bounds; `unit` is for the message."""
        if self.above < value and self.least <= value <= self.most:
            return
        if value > self.most:
            bound = f"at most {self.most:g} {unit}"
        else:
            bound = "positive" if self.above == 0 else f"at least {self.least:g} {unit}"
        raise node.error(f"{node.text} must be {bound.strip()}, such as {self.such_as}")


class Pattern(NamedTuple):
    """Annotation: what a text must look like.

    Attributes:
        regex: The pattern that the whole text must match.
        what: What such a text is called, for messages.
        such_as: An example.
    """

    regex: str
    what: str
    such_as: str


class Among(NamedTuple):
    """Annotation: a text must be a name in a mapping that was read earlier.

    Attributes:
        names: The attribute that holds the mapping.
        what: What such a name is called, for messages.
    """

    names: str
    what: str


class OneOrMore(NamedTuple):
    """Annotation: a list with at least one value; a single one needs no brackets."""


class Output(NamedTuple):
    """Annotation: an output path, which need not exist; relative to the current folder."""


class Kind(ABC):
    """A kind of value."""

    @property
    @abstractmethod
    def such_as(self) -> str:
        """An example, for messages."""

    @abstractmethod
    def read(self, node: YamlNode, scope: Scope) -> Any:
        """Return the value of a node, or raise its `ConfigError`."""

    def write(self, value: Any) -> Any:
        """Return plain data that `read` turns into the value again."""
        return value


@dataclass(frozen=True)
class Quantity(Kind):
    """A number with a unit; a number without a unit is in SI units."""

    unit: Unit
    range: Range | None

    @property
    def such_as(self) -> str:
        return self.range.such_as if self.range else f"0 {self.unit}".removesuffix(" 1")

    def read(self, node: YamlNode, scope: Scope) -> float:
        try:
            value = parse_quantity(node.text, self.unit)
        except UnitError as error:
            raise node.error(str(error)) from None
        if self.range:
            self.range.check(value, node, self.unit.removeprefix("1"))
        return value

    def write(self, value: Any) -> float | str:
        return float(value) if self.unit == "1" else f"{float(value)!r} {self.unit}"


@dataclass(frozen=True)
class Whole(Kind):
    """A whole number."""

    range: Range | None

    @property
    def such_as(self) -> str:
        return self.range.such_as if self.range else "1"

    def read(self, node: YamlNode, scope: Scope) -> int:
        if not re.fullmatch("[+-]?[0-9]{1,99}", node.text):
            raise node.error(f"{node.text!r} is not a whole number, such as {self.such_as}")
        if self.range:
            self.range.check(int(node.text), node)
        return int(node.text)


@dataclass(frozen=True)
class Choice(Kind):
    """One of several words; different words may have the same value."""

    values: Mapping[str, Any]

    @property
    def such_as(self) -> str:
        return next(iter(self.values))

    def read(self, node: YamlNode, scope: Scope) -> Any:
        word = node.text if node.text in self.values else node.text.lower()
        if word not in self.values:
            raise node.error(f"{node.text!r} is not a valid choice{valid_are(word, self.values)}")
        return self.values[word]


@dataclass(frozen=True)
class Text(Kind):
    """Text, optionally with a pattern to match, and a mapping that it is a name in."""

    pattern: Pattern | None
    among: Among | None = None

    @property
    def such_as(self) -> str:
        return self.pattern.such_as if self.pattern else "text"

    def read(self, node: YamlNode, scope: Scope) -> str:
        regex, what, _ = self.pattern or (".*", "text", "")
        if not isinstance(node.value, str) or not re.fullmatch(regex, node.value, re.DOTALL):
            raise node.error(f"{node.text!r} is not {what}, such as {self.such_as}")
        if self.among and node.value not in (names := scope[self.among.names]):
            hint = valid_are(node.value, names)
            raise node.error(f"there is no {self.among.what} {node.value!r}{hint}")
        return node.value


@dataclass(frozen=True)
class File(Kind):
    """A path, relative to the file that names it; it must exist unless it is for output."""

    output: bool

    @property
    def such_as(self) -> str:
        return "runs" if self.output else "path.csv"

    def read(self, node: YamlNode, scope: Scope) -> Path:
        text = Text(Pattern(".+", "a path", self.such_as)).read(node, scope)
        folder = Path.cwd() if self.output else node.location.folder
        path = os.path.abspath(folder / os.path.expanduser(text))
        if not self.output and not os.path.exists(path):
            raise node.error(f"there is no file {path}")
        return Path(path)

    def write(self, value: Any) -> str:
        return str(value)


@dataclass(frozen=True)
class Items(Kind):
    """A list of values.

    Attributes:
        kinds: The kind of each value, or of all values if `many`.
        many: Whether the list has any number of values of one kind.
        bare: Whether there must be a value, and a single one needs no brackets.
    """

    kinds: tuple[Kind, ...]
    many: bool
    bare: bool = False

    @property
    def such_as(self) -> str:
        if self.bare:
            return self.kinds[0].such_as
        return f"[{', '.join(kind.such_as for kind in self.kinds)}]"

    def read(self, node: YamlNode, scope: Scope) -> tuple[Any, ...]:
        if self.bare and not isinstance(node.value, list):
            return (self.kinds[0].read(node, scope),)
        if self.bare and not node.value:
            what = "the list is empty; at least one value is needed"
            raise node.error(f"{what}, such as {self.such_as}")
        if not isinstance(node.value, list):
            raise node.error(f"{node.text!r} is not a list, such as {self.such_as}")
        kinds = self._kinds(len(node.value))
        if len(node.value) != len(kinds):
            given, wanted = len(node.value), len(kinds)
            raise node.error(f"expected {wanted} values, got {given}, such as {self.such_as}")
        return tuple(kind.read(n, scope) for kind, n in zip(kinds, node.value, strict=True))

    def write(self, value: Any) -> list[Any]:
        return [k.write(v) for k, v in zip(self._kinds(len(value)), value, strict=True)]

    def _kinds(self, count: int) -> tuple[Kind, ...]:
        return self.kinds * count if self.many else self.kinds


@dataclass(frozen=True)
class Table(Kind):
    """A mapping from names chosen by the user to values of one kind."""

    key: Kind
    value: Kind

    @property
    def such_as(self) -> str:
        return f"{{{self.key.such_as}: {self.value.such_as}}}"

    def read(self, node: YamlNode, scope: Scope) -> dict[str, Any]:
        if not isinstance(node.value, dict) or not node.value:
            raise node.error(f"{node.text!r} is not a mapping, such as {self.such_as}")
        for name, child in node.value.items():
            self.key.read(YamlNode(child.key or child.location, name, name, node), scope)
        return {name: self.value.read(child, scope) for name, child in node.value.items()}

    def write(self, value: Any) -> dict[str, Any]:
        return {name: self.value.write(each) for name, each in value.items()}


@dataclass(frozen=True)
class Maybe(Kind):
    """A value, or null for None."""

    kind: Kind

    @property
    def such_as(self) -> str:
        return self.kind.such_as

    def read(self, node: YamlNode, scope: Scope) -> Any:
        return None if node.value is None else self.kind.read(node, scope)

    def write(self, value: Any) -> Any:
        return None if value is None else self.kind.write(value)
