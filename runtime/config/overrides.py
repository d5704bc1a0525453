"""Values from elsewhere, such as the command line, that take the place of those in a file."""

from pathlib import Path
from typing import NamedTuple

from runtime.config.tree import ConfigError, Location, Node, parse


class Override(NamedTuple):
    """A value from elsewhere that takes the place of one in the file.

    source: how to name it in messages, such as the option that was given
    path: which value, dotted: keys, a list's indices or roles; `+` is a new item of a list
    value: YAML
    """

    source: str
    path: str
    value: str

    def apply(self, root: Node) -> None:
        """Put the value into the tree; what is missing on the way to it is made."""
        place = Location(self.source, Path.cwd())
        node, names = root, self.path.split(".")
        if not all(names):
            raise ConfigError(f"{place}: {self.path!r} is no path, such as goal.velocity")
        for name, after in zip(names, [*names[1:], None], strict=True):
            if node.value is None:
                node.value = [] if name == "+" else {}
            name = self._spelling(node, name)
            if after is None:
                node.put(name, parse(self.value, place))
            elif name not in node.children:
                node.put(name, Node(place, None))
            node = node.find(name)

    def _spelling(self, node: Node, name: str) -> str:
        """Return the key or index that `name` means in `node`."""
        if isinstance(node.value, list):
            known = {child.role: index for index, child in node.children.items() if child.role}
            if name not in {*known, *node.children, "+"}:
                has = ", ".join([*(known or node.children), "+ for a new one"])
                raise ConfigError(f"{self.source}: {node.path} has no {name}; it has {has}")
            return known.get(name, name)
        if isinstance(node.value, str) or name == "+":
            what = f"{node.path or 'the file'} is no {'list' if name == '+' else 'mapping'}"
            raise ConfigError(f"{self.source}: {what}, so {name} cannot be set in it")
        return name
