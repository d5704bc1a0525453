"""From a tree of nodes to typed values and back, led by nothing but type annotations.

What a value may be is said once, where it is declared: in a dataclass, or in the signature of a
class that a deployment names. `kind_of` understands `float`, `int`, `bool`, `str`, `Path`,
`Literal`, `tuple`, `Mapping`, `X | None`, dataclasses, classes with a `from_node`, and `Annotated`
with a unit such as "m/s" (which goes for each number of a tuple too) or with a mark.
"""

import inspect
import math
from collections import ChainMap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    NamedTuple,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from plant.units import Unit
from runtime.config.kinds import (
    Choice,
    File,
    Items,
    Kind,
    Maybe,
    OneOrMore,
    Output,
    Pattern,
    Quantity,
    Range,
    Scope,
    Table,
    Text,
    Whole,
)
from runtime.config.spelling import nearest
from runtime.config.tree import Node

_M = TypeVar("_M")
_TRUTH = Choice({"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False})


class Derived(NamedTuple):
    """Mark: the default follows from what was read before."""

    make: Callable[[Scope], Any]


class Rest(NamedTuple):
    """Mark: a dict of all other keys, which are the fields that `find` returns for what was read.

    If it returns None, they are kept as they were written.
    """

    find: Callable[[Scope], "Sequence[Field] | None"]


@dataclass(frozen=True)
class Field:
    """A key of a mapping: its attribute or parameter, what it may be, and its default.

    default: `MISSING` if there is none, or if it is derived
    """

    name: str
    kind: Kind
    default: Any
    derived: Derived | None = None

    @property
    def key(self) -> str:
        """How it is written in a file: `class` for `class_`."""
        return self.name.rstrip("_")

    @property
    def required(self) -> bool:
        """Whether it has no default."""
        return self.default is MISSING and not self.derived and not isinstance(self.kind, Record)

    def read(self, node: Node, scope: Scope) -> Any:
        """Return its value in the mapping `node`, or its default."""
        if self.key in node.children:
            return self.kind.read(node.children[self.key], scope)
        if self.derived:
            return self.derived.make(scope)
        if self.default is not MISSING:
            return self.default
        if isinstance(self.kind, Record):  # made of defaults, if they suffice
            return self.kind.read(Node(node.place, {}, self.key, node), scope)
        raise node.error(
            f"the key {self.key!r} is missing, such as {self.key}: {self.kind.such_as}"
        )

    def write(self, value: Any) -> dict[str, Any]:
        """Return the key with its value, or nothing for a default that no file can say."""
        unsaid = value is None or (isinstance(value, float) and not math.isfinite(value))
        if unsaid and value is self.default:
            return {}
        return {self.key: self.kind.write(value)}


@dataclass(frozen=True)
class Record(Kind):
    """A mapping that becomes a dataclass, whose `check(node, scope)` may refuse it.

    If the class has `one_of`, one of these keys is given; if it has `short`, what is no mapping
    stands for that key's value.

    rest: the field that takes all other keys, and what these are
    """

    type: type[Any]
    fields: tuple[Field, ...]
    rest: tuple[str, Rest] | None

    @property
    def such_as(self) -> str:
        """Its first key."""
        first = self.fields[0]
        if hasattr(self.type, "short"):
            return first.kind.such_as
        return f"{{{first.key}: {first.kind.such_as}, ...}}"

    def read(self, node: Node, scope: Scope) -> Any:
        """Return the dataclass, made of what the mapping says and of defaults."""
        if isinstance(node.value, str) and (short := getattr(self.type, "short", "")):
            node = Node(node.place, {short: node}, node.name, node.parent, node.key)
        if not isinstance(node.value, dict):
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
            what = f"{' and '.join(given) or 'none'} given, of which one is wanted"
            raise node.error(f"{what}: {', '.join(one_of)}")
        value = self.type(**values)
        if hasattr(value, "check"):
            value.check(node, around)
        return value

    def _others(self, node: Node, scope: Scope, fields: "Sequence[Field] | None") -> dict[str, Any]:
        known = {field.key for field in self.fields}
        if fields is None:
            return {key: n.plain() for key, n in node.children.items() if key not in known}
        for taken in known & {field.key for field in fields}:
            raise node.error(f"the key {taken!r} has a meaning here; no parameter can be named so")
        _refuse_others(node, (*self.fields, *fields))
        return {field.name: field.read(node, scope) for field in fields}

    def write(self, value: Any) -> dict[str, Any]:
        """Return the mapping, with the defaults."""
        plain: dict[str, Any] = {}
        for field in self.fields:
            plain |= field.write(getattr(value, field.name))
        if self.rest:
            name, rest = self.rest
            others = getattr(value, name)
            fields = rest.find(vars(value))
            if fields is None:
                plain.update(others)
                return plain
            for field in fields:
                plain |= field.write(others[field.name])
        return plain


@dataclass(frozen=True)
class Own(Kind):
    """A class that reads a value itself, by `from_node(node, scope)`; `str` writes it."""

    type: Any

    @property
    def such_as(self) -> str:
        """What the class gives as an example."""
        example: str = self.type.such_as
        return example

    def read(self, node: Node, scope: Scope) -> Any:
        """Return what the class makes of it."""
        return self.type.from_node(node, scope)

    def write(self, value: Any) -> str:
        """Return it as text."""
        return str(value)


def _refuse_others(node: Node, fields: Sequence[Field], allowed: bool = False) -> None:
    """Refuse what is no key of these; where others are allowed, what is meant for a missing one."""
    known = [field.key for field in fields]
    missing = [field.key for field in fields if field.required and field.key not in node.children]
    for key, child in node.children.items():
        hint = "" if key in known else nearest(key, missing if allowed else known)
        if hint or not (allowed or key in known):
            what = f"unknown key {key!r}{hint or ';'} valid are {', '.join(known)}"
            what += ", and what its class takes" if allowed else ""
            raise node.error(what, child.key or child.place)


@cache
def kind_of(annotation: Any, unit: Unit = "1") -> Kind:
    """Return what an annotation lets a file say; raise `TypeError` for one that it cannot."""
    base, *marks = get_args(annotation) if get_origin(annotation) is Annotated else [annotation]
    unit = next((mark for mark in marks if mark in get_args(Unit)), unit)
    bounds = _mark(marks, Range)
    origin, args = get_origin(base), get_args(base)
    if origin in (Union, UnionType) and NoneType in args and len(args) == 2:
        inner = next(arg for arg in args if arg is not NoneType)
        return Maybe(kind_of(Annotated[inner, *marks] if marks else inner, unit))
    if origin is tuple:
        many = args[-1:] == (Ellipsis,)
        items = tuple(kind_of(arg, unit) for arg in args if arg is not Ellipsis)
        return Items(items, many, bare=_mark(marks, OneOrMore) is not None)
    if origin is Mapping:
        return Table(*(kind_of(arg) for arg in args))
    if origin is Literal:
        return Choice({str(value): value for value in args})
    if hasattr(base, "from_node"):
        return Own(base)
    if is_dataclass(base):
        return _record(base)
    leaves: dict[Any, Kind] = {
        float: Quantity(unit, bounds),
        int: Whole(bounds),
        bool: _TRUTH,
        str: Text(_mark(marks, Pattern)),
        Path: File(output=_mark(marks, Output) is not None),
    }
    if base not in leaves:
        raise TypeError(f"a file cannot hold a {base!r}")
    return leaves[base]


def _record(cls: Any) -> Record:
    hints = get_type_hints(cls, include_extras=True)
    found, rest = [], None
    for field in fields(cls):
        marks = getattr(hints[field.name], "__metadata__", ())
        if others := _mark(marks, Rest):
            rest = (field.name, others)
            continue
        derived = _mark(marks, Derived)
        found.append(Field(field.name, kind_of(hints[field.name]), field.default, derived))
    return Record(cls, tuple(found), rest)


def parameters_of(factory: Callable[..., Any]) -> tuple[Field, ...]:
    """Return the keyword-only parameters of a class, but optional ones that no file can hold.

    Raises `TypeError` for one without a default that no file can hold, or whose annotation is
    missing, and `NameError` for an annotation that names nothing.
    """
    found = []
    for name, parameter in inspect.signature(factory, eval_str=True).parameters.items():
        if parameter.kind is not parameter.KEYWORD_ONLY:
            continue
        default = MISSING if parameter.default is parameter.empty else parameter.default
        try:
            found.append(Field(name, kind_of(parameter.annotation), default))
        except TypeError:
            if default is MISSING:
                raise TypeError(f"its parameter {name} has no type that a file can hold") from None
    return tuple(found)


def _mark(marks: Iterable[Any], wanted: type[_M]) -> _M | None:
    return next((mark for mark in marks if isinstance(mark, wanted)), None)
