"""The kinds of value in a file: how each is read from a node, and written again."""

import math
import os
import re
from abc import abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from msgspec import Struct

from plant.units import Unit, UnitError, parse_quantity
from runtime.config.tree import YamlNode
from runtime.errors import valid_are

Scope = Mapping[str, Any]
"""Values read earlier, of the same and the enclosing mappings, by attribute name."""


class Kind(Struct, frozen=True):
    """A kind of value; as an annotation it says how the annotated value is read."""

    such_as: str  # an example, for messages

    @abstractmethod
    def read(self, node: YamlNode, scope: Scope) -> Any:
        """Return the value of a node, or raise its `ConfigError`."""

    def write(self, value: Any) -> Any:
        """Return plain data that `read` turns into the value again; by default of `str`."""
        return value if isinstance(value, int | str) else str(value)


class Number(Kind, frozen=True, kw_only=True):
    """A number from `least` to `most`, and larger than `above`, in SI units."""

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


class Quantity(Number, frozen=True):
    """A number with a unit; a number without a unit is in SI units."""

    unit: Unit = "1"

    def read(self, node: YamlNode, scope: Scope) -> float:
        try:
            value = parse_quantity(node.text, self.unit)
        except UnitError as error:
            raise node.error(str(error)) from None
        self.check(value, node, self.unit.removeprefix("1"))
        return value

    def write(self, value: Any) -> float | str:
        plain = self.unit in ("1", "rad or m")
        return float(value) if plain else f"{float(value)!r} {self.unit}"


class Whole(Number, frozen=True):
    """A whole number."""

    def read(self, node: YamlNode, scope: Scope) -> int:
        if not re.fullmatch("[+-]?[0-9]{1,99}", node.text):
            raise node.error(f"{node.text!r} is not a whole number, such as {self.such_as}")
        self.check(int(node.text), node)
        return int(node.text)


class Choice(Kind, frozen=True):
    """One of several words, in any case; different words may have the same value."""

    values: Mapping[str, Any]

    def read(self, node: YamlNode, scope: Scope) -> Any:
        word = node.text if node.text in self.values else node.text.lower()
        if word not in self.values:
            raise node.error(f"{node.text!r} is not a valid choice{valid_are(word, self.values)}")
        return self.values[word]


class Text(Kind, frozen=True):
    """Text as it was written, if the whole of it matches a pattern."""

    what: str = "text"  # what such a text is called, for messages
    regex: str = ".*"

    def read(self, node: YamlNode, scope: Scope) -> str:
        if node.value is None or not re.fullmatch(self.regex, node.value, re.DOTALL):
            raise node.error(f"{node.text!r} is not {self.what}, such as {self.such_as}")
        return node.value


class File(Kind, frozen=True):
    """A path, relative to the file that names it, which must exist.

    One of `output` need not exist, and is relative to the current folder.
    """

    output: bool = False

    def read(self, node: YamlNode, scope: Scope) -> Path:
        text = Text(self.such_as, "a path", ".+").read(node, scope)
        start = node.location._replace(folder=Path.cwd()) if self.output else node.location
        path = start.absolute(text)
        if not self.output and not os.path.exists(path):
            raise node.error(f"there is no file {path}")
        return path


class Items(Kind, frozen=True):
    """A list of values.

    Attributes:
        kinds: The kind of each value, or of all values if `many`.
        many: Whether the list has any number of values of one kind.
        bare: Whether there must be a value, and a single one needs no brackets.
    """

    kinds: tuple[Kind, ...]
    many: bool = False
    bare: bool = False

    def read(self, node: YamlNode, scope: Scope) -> tuple[Any, ...]:
        nodes = list(node.children.values())
        if self.bare and node.shape is not list:
            return (self.kinds[0].read(node, scope),)
        if self.bare and not nodes:
            what = "the list is empty; at least one value is needed"
            raise node.error(f"{what}, such as {self.such_as}")
        if node.shape is not list:
            raise node.error(f"{node.text!r} is not a list, such as {self.such_as}")
        kinds = self._kinds(len(nodes))
        if len(nodes) != len(kinds):
            what = f"expected {len(kinds)} values, got {len(nodes)}"
            raise node.error(f"{what}, such as {self.such_as}")
        return tuple(kind.read(each, scope) for kind, each in zip(kinds, nodes, strict=True))

    def write(self, value: Any) -> list[Any]:
        return [k.write(v) for k, v in zip(self._kinds(len(value)), value, strict=True)]

    def _kinds(self, count: int) -> tuple[Kind, ...]:
        return self.kinds * count if self.many else self.kinds


class Table(Kind, frozen=True):
    """A mapping from names chosen by the user to values of one kind, in the order as written."""

    key: Kind
    value: Kind

    def read(self, node: YamlNode, scope: Scope) -> dict[str, Any]:
        if node.shape is not dict or not node.children:
            raise node.error(f"{node.text!r} is not a mapping, such as {self.such_as}")
        for name, child in node.children.items():
            key = YamlNode(child.key or child.location, name, name=name, parent=node)
            self.key.read(key, scope)
        return {name: self.value.read(child, scope) for name, child in node.children.items()}

    def write(self, value: Any) -> dict[str, Any]:
        return {name: self.value.write(each) for name, each in value.items()}


class Maybe(Kind, frozen=True):
    """A value, or null for None."""

    kind: Kind

    def read(self, node: YamlNode, scope: Scope) -> Any:
        return None if node.is_null else self.kind.read(node, scope)

    def write(self, value: Any) -> Any:
        return None if value is None else self.kind.write(value)
