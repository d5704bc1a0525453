"""Values from elsewhere, such as the command line, that replace those in a file."""

from pathlib import Path
from typing import NamedTuple

from runtime.config.tree import ConfigError, Location, YamlNode, parse


class Override(NamedTuple):
    """A value that replaces one in a file."""

    source: str  # its name in messages, such as the option that was given
    path: str  # of keys with dots between, and of indices or roles of list items; `+` appends one
    value: str  # as YAML

    def apply(self, root: YamlNode) -> None:
        """Set the value in a tree, and create missing nodes on the way to it."""
        location = Location(self.source, Path.cwd())
        node, names = root, self.path.split(".")
        if not all(names):
            raise ConfigError(f"{location}: {self.path!r} is not a path, such as goal.velocity")
        if root.shape is not dict and not root.is_null:
            what = f"the file is not a mapping, so {names[0]} cannot be set in it"
            raise ConfigError(f"{self.source}: {what}")
        for name, after in zip(names, [*names[1:], None], strict=True):
            if node.is_null:
                node.shape = list if name == "+" else dict
            name = self._key(node, name)
            if after is None:
                node.put(name, parse(self.value, location))
            elif name not in node.children:
                node.put(name, YamlNode(location))
            node = node.find(name)

    def _key(self, node: YamlNode, name: str) -> str:
        """Return the key or index of the child that `name` refers to."""
        if node.shape is list:
            known = {child.role: index for index, child in node.children.items() if child.role}
            if name not in {*known, *node.children, "+"}:
                has = ", ".join([*(known or node.children), "+ for a new one"])
                raise ConfigError(f"{self.source}: {node.path} has no {name}; it has {has}")
            return known.get(name, name)
        if node.shape is str or name == "+":
            what = f"{node.path or 'the file'} is not a {'list' if name == '+' else 'mapping'}"
            raise ConfigError(f"{self.source}: {what}, so {name} cannot be set in it")
        return name
