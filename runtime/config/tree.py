"""A YAML file as a tree of nodes, each of which knows where it was written."""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from plant.errors import MsmaError

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_MOST_BYTES = 4_000_000
_MOST_NODES = 100_000  # with every alias written out
_DEEPEST = 20
_NOTHING = ("", "~", "null", "Null", "NULL")


class ConfigError(MsmaError, ValueError):
    """A value in a deployment that cannot be used: where it stands, and what would be valid."""


class Location(NamedTuple):
    """Where a value was written, for messages: a place in a file, or a command-line option.

    source: the file's name, or the option as it was given
    folder: what relative paths written there are relative to
    line, column: from 1; line 0 if the source is an option
    """

    source: str
    folder: Path
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        return f"{self.source}:{self.line}:{self.column}" if self.line else self.source


@dataclass(eq=False)
class Node:
    """A value, a list or a mapping as it was written; None is a value left empty, or null."""

    place: Location
    value: "str | list[Node] | dict[str, Node] | None"
    name: str = ""
    parent: "Node | None" = field(default=None, repr=False)
    key: Location | None = None  # where its key was written, if it has one

    @property
    def path(self) -> str:
        """Its name from the root on, as `--set` takes it; a list's item goes by its role."""
        if self.parent is None:
            return ""
        name = self.role or self.name
        return f"{self.parent.path}.{name}" if self.parent.path else name

    @property
    def role(self) -> str:
        """The name that an item of a list may go by, apart from its index, or nothing."""
        listed = self.parent is not None and isinstance(self.parent.value, list)
        role = self.children["role"].text if listed and "role" in self.children else ""
        return role if re.fullmatch(r"[a-z][\w/-]*", role) else ""

    @property
    def text(self) -> str:
        """What it says, in one line."""
        if isinstance(self.value, dict):
            return "{" + ", ".join(f"{key}: {n.text}" for key, n in self.value.items()) + "}"
        if isinstance(self.value, list):
            return "[" + ", ".join(node.text for node in self.value) + "]"
        return " ".join((self.value or "").split())

    @property
    def children(self) -> "dict[str, Node]":
        """What it holds, by key, or by index as text; nothing for a plain value."""
        if isinstance(self.value, list):
            return {str(index): node for index, node in enumerate(self.value)}
        return self.value if isinstance(self.value, dict) else {}

    def error(self, message: str, place: Location | None = None) -> ConfigError:
        """Say in one line what is wrong with this value, or with what stands at `place` in it."""
        parts = str(place or self.place), self.path, " ".join(message.splitlines())
        return ConfigError(": ".join(filter(None, parts)))

    def find(self, *names: str | int) -> "Node":
        """Return the node of that path, or the last on the way to it that was written."""
        node = self
        for name in names:
            if str(name) not in node.children:
                return node
            node = node.children[str(name)]
        return node

    def plain(self) -> Any:
        """Return what it holds as plain dicts, lists and text."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        return [node.plain() for node in self.value] if isinstance(self.value, list) else self.value

    def put(self, name: str, node: "Node") -> None:
        """Add or replace a child of a mapping; of a list, its index or `+` for a new item."""
        if isinstance(self.value, list):
            if name == "+":
                name = str(len(self.value))
                self.value.append(node)
            else:
                self.value[int(name)] = node
        else:
            assert isinstance(self.value, dict)
            self.value[name] = node
        node.name, node.parent = name, self


def read_file(file: str | os.PathLike[str]) -> Node:
    """Read a YAML file; every `ConfigError` names it as `file` does."""
    source = str(file) or "''"
    try:
        with open(file, "rb") as stream:
            data = stream.read(_MOST_BYTES + 1)
    except IsADirectoryError:
        raise ConfigError(f"{source}: is a folder; a YAML file is wanted") from None
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        raise ConfigError(f"{source}: {getattr(error, 'strerror', None) or error}") from None
    if len(data) > _MOST_BYTES:
        raise ConfigError(f"{source}: is larger than {_MOST_BYTES // 1_000_000} MB")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ConfigError(f"{source}:{line}: is not text in UTF-8; save it as UTF-8") from None
    return parse(text, Location(source, Path(os.path.abspath(source)).parent, 1, 1))


def parse(text: str, start: Location) -> Node:
    """Turn YAML into a tree; aliases and merge keys are written out, tags are refused.

    The nodes count their lines and columns from `start`, or have just its place if it has no line.
    Raises `ConfigError` for what is not YAML, keys given twice, and what is endlessly large.
    """
    try:
        return _Builder(text, start).document()
    except yaml.MarkedYAMLError as error:
        place = start
        if start.line and error.problem_mark is not None:
            mark = error.problem_mark
            place = start._replace(line=mark.line + 1, column=mark.column + 1)
        raise ConfigError(f"{place}: is not YAML: {error.problem}") from None
    except yaml.reader.ReaderError as error:
        if start.line:
            before = text[: text.index(chr(error.character))]
            line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
            start = start._replace(line=line, column=column)
        what = f"the character {chr(error.character)!r} is not allowed"
        raise ConfigError(f"{start}: is not YAML: {what}") from None
    except UnicodeEncodeError:
        raise ConfigError(f"{start}: is not text in UTF-8") from None


class _Builder:
    """Makes the tree from the parser's events, so that no file makes it deep or large."""

    def __init__(self, text: str, start: Location) -> None:
        self.events: Iterator[Any] = iter(yaml.parse(text, Loader=_LOADER))
        self.start = start
        self.anchors: dict[str, Node] = {}
        self.count = 0

    def document(self) -> Node:
        next(self.events)  # the start of the stream
        if isinstance(next(self.events), yaml.StreamEndEvent):
            return Node(self.start, None)
        root = self.node(next(self.events), 0)
        next(self.events)  # the end of the document
        after = next(self.events)
        if not isinstance(after, yaml.StreamEndEvent):
            raise ConfigError(f"{self.place(after)}: a second document; one a file is wanted")
        return root

    def place(self, event: Any) -> Location:
        if not self.start.line:
            return self.start
        mark = event.start_mark
        return self.start._replace(line=mark.line + 1, column=mark.column + 1)

    def node(self, event: Any, depth: int) -> Node:
        place = self.place(event)
        self.spend(1, depth, place)
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in self.anchors:
                raise ConfigError(f"{place}: the alias *{event.anchor} has no &{event.anchor} yet")
            return self.copy(self.anchors[event.anchor], depth)
        if event.tag is not None:
            raise ConfigError(f"{place}: the tag {event.tag} is not used here; leave it out")
        if isinstance(event, yaml.ScalarEvent):
            empty = event.implicit[0] and event.value in _NOTHING
            node = Node(place, None if empty else event.value)
        elif isinstance(event, yaml.SequenceStartEvent):
            node = Node(place, [])
            while not isinstance(item := next(self.events), yaml.SequenceEndEvent):
                node.put("+", self.node(item, depth + 1))
        else:
            node = self.mapping(Node(place, {}), depth)
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        return node

    def mapping(self, node: Node, depth: int) -> Node:
        merged: list[Node] = []
        while not isinstance(event := next(self.events), yaml.MappingEndEvent):
            place = self.place(event)
            if not isinstance(event, yaml.ScalarEvent):
                raise ConfigError(f"{place}: a key must be plain text")
            child = self.node(next(self.events), depth + 1)
            child.key = place
            if event.value == "<<" and event.implicit[0]:
                merged += child.value if isinstance(child.value, list) else [child]
            elif event.value in node.children:
                first = node.children[event.value].key
                raise ConfigError(f"{place}: the key {event.value!r} is given twice: {first} too")
            else:
                node.put(event.value, child)
        for source in merged:
            if not isinstance(source.value, dict):
                raise ConfigError(f"{source.place}: << takes a mapping, or a list of mappings")
            for key, child in source.value.items():
                if key not in node.children:
                    node.put(key, self.copy(child, depth))
        return node

    def copy(self, node: Node, depth: int) -> Node:
        """Write out once more what an anchor stands for."""
        self.spend(1, depth, node.place)
        copy = Node(node.place, node.value, key=node.key)
        if isinstance(node.value, list | dict):
            copy.value = type(node.value)()
            for name, child in node.children.items():
                copy.put("+" if isinstance(copy.value, list) else name, self.copy(child, depth + 1))
        return copy

    def spend(self, nodes: int, depth: int, place: Location) -> None:
        self.count += nodes
        if depth > _DEEPEST:
            raise ConfigError(f"{place}: is nested deeper than {_DEEPEST} levels")
        if self.count > _MOST_NODES:
            raise ConfigError(f"{place}: more than {_MOST_NODES} values, with aliases written out")
