"""The security of a deployment: where its certificates and private keys are."""

import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, Self

from runtime.config.kinds import Pattern, Scope, Text
from runtime.config.tree import ConfigError, Node
from runtime.wire.security import Credentials


@dataclass(frozen=True)
class KeyFolder:
    """A folder for keys, which may still have to be made, and the file that names it."""

    path: Path
    file: str = field(compare=False)

    such_as: ClassVar[str] = "keys"

    @classmethod
    def from_node(cls, node: Node, scope: Scope) -> Self:
        """Read a path that is relative to the file that says it."""
        text = Text(Pattern(".+", "a folder", cls.such_as)).read(node, scope)
        path = os.path.abspath(node.place.folder / os.path.expanduser(text))
        return cls(Path(path), node.place.source)

    def __str__(self) -> str:
        return str(self.path)


@dataclass(frozen=True, kw_only=True)
class SecuritySpec:
    """Who may join: only who has a certificate, and to do what his name in it allows.

    Attributes:
        keys: The folder of the certificates and private keys, which `msma keys` makes.
    """

    keys: KeyFolder

    def credentials(self, name: str, roles: Sequence[str]) -> Credentials:
        """Return what a process of that name needs, or say by `ConfigError` how to get it."""
        credentials = Credentials(self.keys.path, name, tuple(roles))
        if not credentials.authority.exists():
            raise self._error(f"there are no keys in {self.keys}", "")
        for file in (credentials.certificate, credentials.private_key):
            if not file.exists():
                raise self._error(f"there is no {file}", " --overwrite")
            if not os.access(file, os.R_OK):
                raise ConfigError(f"{self.keys.file}: security.keys: {file} may not be read")
        return credentials

    def remedy(self, how: str = "") -> str:
        """Return the command that makes keys."""
        folder = os.path.relpath(self.keys.path)
        folder = str(self.keys) if folder.startswith("..") else folder
        return f"msma keys{how} {shlex.quote(folder)} {shlex.quote(self.keys.file)}"

    def _error(self, what: str, how: str) -> ConfigError:
        return ConfigError(
            f"{self.keys.file}: security.keys: {what}; make them: {self.remedy(how)}"
        )
