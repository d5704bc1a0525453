"""Typed values from a tree of nodes and back, by type annotations alone.

What a value may be is stated once, where it is declared: in a dataclass, or in the signature of a
class that a deployment names. `kind_of` understands `float`, `int`, `bool`, `str`, `Path`,
`Literal`, `tuple`, `Mapping`, `X | None`, dataclasses, and `Annotated` with a unit such as "m/s",
which applies to all numbers of a tuple, or with a `Kind`.
"""

import inspect
import math
import typing
from collections import ChainMap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

from msgspec import Struct

from plant.units import Unit
from runtime.config import kinds
from runtime.config.kinds import Kind, Scope
from runtime.config.tree import YamlNode
from runtime.errors import nearest

_TRUTH = kinds.Choice(
    "true", {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
)


class Derived(NamedTuple):
    """Annotation: the default is computed from values read earlier."""

    make: Callable[[Scope], Any]


class Rest(NamedTuple):
    """Annotation: a dict of all other keys, with the fields that `find` returns for them.

    It gets the values read earlier, and returns None to keep the others as they were written.
    """

    find: Callable[[Scope], "Sequence[Field] | None"]


class Field(Struct, frozen=True):
    """A key of a mapping, by the name of the attribute or parameter."""

    name: str
    kind: Kind
    default: Any  # or a `Derived` one, or `MISSING`

    @property
    def key(self) -> str:
        """The key in a file: `class` for `class_`."""
        return self.name.rstrip("_")

    @property
    def required(self) -> bool:
        """Whether it has no default."""
        return self.default is MISSING and not isinstance(self.kind, Structure)

    def read(self, node: YamlNode, scope: Scope) -> Any:
        """Return its value in the mapping `node`, or its default."""
        if self.key in node.children:
            return self.kind.read(node.children[self.key], scope)
        if isinstance(self.default, Derived):
            return self.default.make(scope)
        if self.default is not MISSING:
            return self.default
        if isinstance(self.kind, Structure):  # which may have defaults for all its keys
            empty = YamlNode(node.location, shape=dict, name=self.key, parent=node)
            return self.kind.read(empty, scope)
        raise node.error(
            f"the key {self.key!r} is missing, such as {self.key}: {self.kind.such_as}"
        )

    def write(self, value: Any) -> dict[str, Any]:
        """Return the key with its value; nothing for a default that a file cannot hold."""
        unwritable = value is None or (isinstance(value, float) and not math.isfinite(value))
        if unwritable and value is self.default:
            return {}
        return {self.key: self.kind.write(value)}


class Structure(Kind, frozen=True):
    """A mapping that becomes a dataclass.

    A method `check(node, scope)` of the class may raise an error. If the class has `one_of`,
    exactly one of these keys must be given. If it has `short`, plain text is the value of that key.
    """

    type: type[Any]
    fields: tuple[Field, ...]
    rest: tuple[str, Rest] | None  # the field that takes all other keys, and its annotation

    def read(self, node: YamlNode, scope: Scope) -> Any:
        if node.value is not None and (short := getattr(self.type, "short", "")):
            node = replace(node, value=None, shape=dict, children={short: node})
        if node.shape is not dict:
            raise node.error(f"{node.text!r} is not a mapping, such as {self.such_as}")
        _refuse_others(node, self.fields, allowed=self.rest is not None)
        values: dict[str, Any] = {}
        around: Scope = ChainMap(values, dict(scope))
        for field in self.fields:
            values[field.name] = field.read(node, around)
        if self.rest:
            name, rest = self.rest
            values[name] = self._others(node, around, rest.find(around))
        one_of = getattr(self.type, "one_of", ())
        given = [key for key in one_of if key in node.children]
        if one_of and len(given) != 1:
            what = f"exactly one of {', '.join(one_of)} is needed"
            raise node.error(f"{what}, got {' and '.join(given) or 'none'}")
        try:
            value = self.type(**values)
        except ValueError as error:
            raise node.blame(error) from error
        if hasattr(value, "check"):
            value.check(node, around)
        return value

    def _others(
        self, node: YamlNode, scope: Scope, fields: "Sequence[Field] | None"
    ) -> dict[str, Any]:
        known = {field.key for field in self.fields}
        if fields is None:
            return {key: n.plain() for key, n in node.children.items() if key not in known}
        for taken in known & {field.key for field in fields}:
            raise node.error(f"the key {taken!r} is not available for a parameter of the class")
        _refuse_others(node, (*self.fields, *fields))
        return {field.name: field.read(node, scope) for field in fields}

    def write(self, value: Any) -> dict[str, Any]:
        name, rest = self.rest or ("", None)
        others = vars(value).get(name, {})
        fields = rest.find(vars(value)) if rest else ()
        plain = dict(others) if fields is None else {}
        for field in (*self.fields, *(fields or ())):
            plain |= field.write((vars(value) | others)[field.name])
        return plain


def _refuse_others(node: YamlNode, fields: Sequence[Field], allowed: bool = False) -> None:
    """Refuse unknown keys; if others are allowed, only those close to a missing required key."""
    known = [field.key for field in fields]
    missing = [field.key for field in fields if field.required and field.key not in node.children]
    for key, child in node.children.items():
        hint = "" if key in known else nearest(key, missing if allowed else known)
        if hint or not (allowed or key in known):
            what = f"unknown key {key!r}{hint or ';'} valid are {', '.join(known)}"
            what += ", and the parameters of its class" if allowed else ""
            raise node.error(what, child.key or child.location)


@cache
def kind_of(annotation: Any, unit: Unit = "1") -> Kind:
    """Return the kind of value of a type annotation; `unit` is the default of its numbers.

    `TypeError` if a file cannot hold such a value.
    """
    base, *marks = get_args(annotation) if get_origin(annotation) is Annotated else [annotation]
    given: Kind | None = _find(marks, Kind)
    if given:
        return given
    unit = next((mark for mark in marks if mark in get_args(Unit)), unit)
    origin, args = get_origin(base), get_args(base)
    if origin in (Union, UnionType) and NoneType in args and len(args) == 2:
        inner = kind_of(next(arg for arg in args if arg is not NoneType), unit)
        return kinds.Maybe(inner.such_as, inner)
    if origin is tuple:
        items = tuple(kind_of(arg, unit) for arg in args if arg is not Ellipsis)
        such_as = f"[{', '.join(item.such_as for item in items)}]"
        return kinds.Items(such_as, items, many=args[-1:] == (Ellipsis,))
    if origin is Mapping:
        key, value = map(kind_of, args)
        return kinds.Table(f"{{{key.such_as}: {value.such_as}}}", key, value)
    if origin is Literal:
        return kinds.Choice(str(args[0]), {str(value): value for value in args})
    if is_dataclass(base):
        return _structure(base)
    leaves: dict[Any, Kind] = {
        float: kinds.Quantity(f"0 {unit}".removesuffix(" 1"), unit),
        int: kinds.Whole("1"),
        bool: _TRUTH,
        str: kinds.Text("text"),
        Path: kinds.File("path.csv"),
    }
    if base not in leaves:
        raise TypeError(f"a file cannot hold a {base!r}")
    return leaves[base]


def _structure(cls: Any) -> Structure:
    hints = get_type_hints(cls, include_extras=True)
    found, rest = [], None
    for field in fields(cls):
        marks = getattr(hints[field.name], "__metadata__", ())
        if others := _find(marks, Rest):
            rest = (field.name, others)
            continue
        default = _find(marks, Derived) or field.default
        found.append(Field(field.name, kind_of(hints[field.name]), default))
    first = found[0].kind.such_as
    such_as = first if hasattr(cls, "short") else f"{{{found[0].key}: {first}, ...}}"
    return Structure(such_as, cls, tuple(found), rest)


def parameters_of(factory: Callable[..., Any]) -> tuple[Field, ...]:
    """Return the keyword-only parameters of a class, without optional ones that no file can hold.

    Raises:
        TypeError: A required parameter has no annotation, or one that no file can hold.
        NameError: An annotation uses an unknown name.
    """
    found = []
    for name, parameter in inspect.signature(factory, eval_str=True).parameters.items():
        if get_origin(parameter.annotation) is typing.Unpack:  # of a TypedDict of optional keys
            (keys,) = get_args(parameter.annotation)
            hints = get_type_hints(keys, include_extras=True)
            found += [Field(key, kind_of(hint), None) for key, hint in hints.items()]
        if parameter.kind is not parameter.KEYWORD_ONLY:
            continue
        default = MISSING if parameter.default is parameter.empty else parameter.default
        try:
            found.append(Field(name, kind_of(parameter.annotation), default))
        except TypeError:
            if default is MISSING:
                raise TypeError(f"its parameter {name} has no type that a file can hold") from None
    return tuple(found)


def _find(marks: Iterable[Any], wanted: type[Any]) -> Any:
    return next((mark for mark in marks if isinstance(mark, wanted)), None)
