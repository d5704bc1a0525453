"""A YAML file as a tree of nodes, each with its location in the file."""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from plant.errors import MsmaError

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_MAX_BYTES = 4_000_000
_MAX_NODES = 100_000  # with aliases expanded
_MAX_DEPTH = 20
_NULLS = ("", "~", "null", "Null", "NULL")


class ConfigError(MsmaError, ValueError):
    """A value in a deployment that cannot be used; the message says where, and what is valid."""


class Location(NamedTuple):
    """Where a value was written, for messages: in a file, or as a command-line option.

    Lines and columns count from 1; an option has none.
    """

    source: str  # the file's name, or the option as it was given
    folder: Path  # which relative paths in the value start from
    line: int = 0
    column: int = 0

    def absolute(self, path: str) -> Path:
        """Return the absolute path of what a value here names."""
        return Path(os.path.abspath(self.folder / os.path.expanduser(path)))

    def __str__(self) -> str:
        return f"{self.source}:{self.line}:{self.column}" if self.line else self.source


@dataclass(eq=False)
class YamlNode:
    """A value, a list or a mapping as it was written."""

    location: Location
    value: str | None = None  # the text of a plain value, unless it is empty or null
    shape: type = str  # or `list` or `dict`
    children: "dict[str, YamlNode]" = field(default_factory=dict)  # by key, or index as text
    name: str = ""  # its key or index in the parent
    parent: "YamlNode | None" = field(default=None, repr=False)
    key: Location | None = None  # where its key was written

    @property
    def path(self) -> str:
        """Its path from the root, as in `--set`; list items are named by their role, if any."""
        if self.parent is None:
            return ""
        name = self.role or self.name
        return f"{self.parent.path}.{name}" if self.parent.path else name

    @property
    def role(self) -> str:
        """The role that names an item of a list instead of its index; empty if there is none."""
        listed = self.parent is not None and self.parent.shape is list
        role = self.children["role"].text if listed and "role" in self.children else ""
        return role if re.fullmatch(r"[a-z][\w/*-]*", role) else ""

    @property
    def text(self) -> str:
        """Its content in one line."""
        if self.shape is dict:
            return "{" + ", ".join(f"{key}: {n.text}" for key, n in self.children.items()) + "}"
        if self.shape is list:
            return "[" + ", ".join(node.text for node in self.children.values()) + "]"
        return " ".join((self.value or "").split())

    @property
    def is_null(self) -> bool:
        """Whether it is a plain value, and empty or null."""
        return self.shape is str and self.value is None

    def error(self, message: str, location: Location | None = None) -> ConfigError:
        """Return the error for this value, or for what is at another location inside it."""
        parts = str(location or self.location), self.path, " ".join(message.splitlines())
        return ConfigError(": ".join(filter(None, parts)))

    def blame(self, error: ValueError) -> ConfigError:
        """Return what a class says of its values, at the key that it begins with, if any."""
        name, _, what = str(error).partition(": ")
        return self.children[name].error(what) if name in self.children else self.error(str(error))

    def find(self, *names: str | int) -> "YamlNode":
        """Return the node at a path, or the last existing one on the way to it."""
        node = self
        for name in names:
            if str(name) not in node.children:
                return node
            node = node.children[str(name)]
        return node

    def all_named(self, name: str) -> "Iterator[YamlNode]":
        """Yield the nodes of that key, in it and in all that it holds."""
        for key, node in self.children.items():
            if key == name:
                yield node
            else:
                yield from node.all_named(name)

    def plain(self) -> Any:
        """Return its content as plain dicts, lists and text."""
        plain = {key: node.plain() for key, node in self.children.items()}
        if self.shape is str:
            return self.value
        return plain if self.shape is dict else list(plain.values())

    def put(self, name: str, node: "YamlNode") -> None:
        """Set a child of a mapping by key, or of a list by index, where `+` appends."""
        if self.shape is list and name == "+":
            name = str(len(self.children))
        self.children[name] = node
        node.name, node.parent = name, self


def read_file(file: str | os.PathLike[str]) -> YamlNode:
    """Read a YAML file; `ConfigError`, which names it, if it cannot be read or is no valid YAML."""
    source = str(file) or "''"
    try:
        with open(file, "rb") as stream:
            data = stream.read(_MAX_BYTES + 1)
    except IsADirectoryError:
        raise ConfigError(f"{source}: is a folder, not a YAML file") from None
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        raise ConfigError(f"{source}: {getattr(error, 'strerror', None) or error}") from None
    if len(data) > _MAX_BYTES:
        raise ConfigError(f"{source}: is larger than {_MAX_BYTES // 1_000_000} MB")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ConfigError(f"{source}:{line}: is not UTF-8 text; save it as UTF-8") from None
    return parse(text, Location(source, Path(os.path.abspath(source)).parent, 1, 1))


def parse(text: str, start: Location) -> YamlNode:
    """Parse YAML that begins at a location, or is of an option; expand aliases and merge keys.

    `ConfigError` if it is not YAML, has duplicate keys or tags, or is too large or too deep.
    """
    try:
        return _Builder(text, start).document()
    except yaml.MarkedYAMLError as error:
        location, mark = start, error.problem_mark
        if mark is not None and "nesting depth" in str(error.problem):
            # PyYAML 6.0.4 reads ahead to its own limit: what is before that is too deep for ours.
            return parse(text[: mark.index], start)
        if start.line and mark is not None:
            location = start._replace(line=mark.line + 1, column=mark.column + 1)
        raise ConfigError(f"{location}: is not YAML: {error.problem}") from None
    except yaml.reader.ReaderError as error:
        if start.line:
            before = text[: text.index(chr(error.character))]
            line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
            start = start._replace(line=line, column=column)
        what = f"the character {chr(error.character)!r} is not allowed"
        raise ConfigError(f"{start}: is not YAML: {what}") from None
    except UnicodeEncodeError:
        raise ConfigError(f"{start}: is not UTF-8 text") from None


class _Builder:
    """Builds the tree from the parser's events, within limits of depth and size."""

    def __init__(self, text: str, start: Location) -> None:
        self.events: Iterator[Any] = iter(yaml.parse(text, Loader=_LOADER))
        self.start = start
        self.anchors: dict[str, YamlNode] = {}
        self.count = 0

    def document(self) -> YamlNode:
        next(self.events)  # the start of the stream
        if isinstance(next(self.events), yaml.StreamEndEvent):
            return YamlNode(self.start)
        root = self.node(next(self.events), 0)
        next(self.events)  # the end of the document
        after = next(self.events)
        if not isinstance(after, yaml.StreamEndEvent):
            where = self.location(after)
            raise ConfigError(f"{where}: a second document; a file must have only one")
        return root

    def location(self, event: Any) -> Location:
        if not self.start.line:
            return self.start
        mark = event.start_mark
        return self.start._replace(line=mark.line + 1, column=mark.column + 1)

    def node(self, event: Any, depth: int) -> YamlNode:
        location = self.location(event)
        self.count_node(depth, location)
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in self.anchors:
                what = f"the alias *{event.anchor} has no anchor &{event.anchor} before it"
                raise ConfigError(f"{location}: {what}")
            return self.copy(self.anchors[event.anchor], depth)
        if event.tag is not None:
            raise ConfigError(f"{location}: the tag {event.tag} is not allowed; remove it")
        if isinstance(event, yaml.ScalarEvent):
            empty = event.implicit[0] and event.value in _NULLS
            node = YamlNode(location, None if empty else event.value)
        elif isinstance(event, yaml.SequenceStartEvent):
            node = YamlNode(location, shape=list)
            while not isinstance(item := next(self.events), yaml.SequenceEndEvent):
                node.put("+", self.node(item, depth + 1))
        else:
            node = self.mapping(YamlNode(location, shape=dict), depth)
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        return node

    def mapping(self, node: YamlNode, depth: int) -> YamlNode:
        merged: list[YamlNode] = []
        while not isinstance(event := next(self.events), yaml.MappingEndEvent):
            location = self.location(event)
            if not isinstance(event, yaml.ScalarEvent):
                raise ConfigError(f"{location}: a key must be plain text")
            child = self.node(next(self.events), depth + 1)
            child.key = location
            if event.value == "<<" and event.implicit[0]:
                merged += child.children.values() if child.shape is list else [child]
            elif event.value in node.children:
                first = node.children[event.value].key
                raise ConfigError(
                    f"{location}: duplicate key {event.value!r}, first given at {first}"
                )
            else:
                node.put(event.value, child)
        for source in merged:
            if source.shape is not dict:
                raise ConfigError(f"{source.location}: << takes a mapping, or a list of mappings")
            for key, child in source.children.items():
                if key not in node.children:
                    node.put(key, self.copy(child, depth))
        return node

    def copy(self, node: YamlNode, depth: int) -> YamlNode:
        """Copy an anchor's node to an alias."""
        self.count_node(depth, node.location)
        copy = YamlNode(node.location, node.value, node.shape, key=node.key)
        for name, child in node.children.items():
            copy.put(name, self.copy(child, depth + 1))
        return copy

    def count_node(self, depth: int, location: Location) -> None:
        self.count += 1
        if depth > _MAX_DEPTH:
            raise ConfigError(f"{location}: is nested deeper than {_MAX_DEPTH} levels")
        if self.count > _MAX_NODES:
            raise ConfigError(f"{location}: more than {_MAX_NODES} values, with aliases expanded")
