"""The security of a deployment: the folder of its certificates and private keys."""

import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from runtime.config.kinds import Kind, Scope, Text
from runtime.config.tree import ConfigError, YamlNode
from runtime.wire.security import Credentials
from runtime.wire.topics import STANDARD, Contract


@dataclass(frozen=True)
class KeyFolder:
    """A folder for certificates and private keys, which need not exist yet."""

    path: Path
    file: str = field(compare=False)  # the deployment file that names it

    def __str__(self) -> str:
        return str(self.path)


class _Folder(Kind, frozen=True):
    """A folder, relative to the file that names it."""

    def read(self, node: YamlNode, scope: Scope) -> KeyFolder:
        text = Text(self.such_as, "a folder", ".+").read(node, scope)
        return KeyFolder(node.location.absolute(text), node.location.source)


@dataclass(frozen=True, kw_only=True)
class SecuritySpec:
    """Who may join: only processes with a certificate, each with the rights of its name.

    Attributes:
        keys: Folder of the certificates and private keys, which `msma keys` creates.
    """

    keys: Annotated[KeyFolder, _Folder("keys")]

    def credentials(
        self, name: str, roles: Sequence[str], contract: Contract = STANDARD
    ) -> Credentials:
        """Return the credentials of a role or of `OPERATOR`; `roles` are those of the robot.

        `ConfigError` if a file is missing or cannot be read; the message says how to create it.
        """
        credentials = Credentials(self.keys.path, name, tuple(roles), contract)
        if not credentials.authority.exists():
            raise self._error(f"there are no certificates in {self.keys}", self.remedy())
        for file in (credentials.certificate, credentials.private_key):
            if not file.exists():
                raise self._error(f"there is no {file}", self.remedy(" --overwrite"))
            if not os.access(file, os.R_OK):
                raise ConfigError(f"{self.keys.file}: security.keys: {file} cannot be read")
        return credentials

    def remedy(self, option: str = "") -> str:
        """Return the command that creates the files."""
        folder = os.path.relpath(self.keys.path)
        folder = str(self.keys) if folder.startswith("..") else folder
        return f"msma keys{option} {shlex.quote(folder)} {shlex.quote(self.keys.file)}"

    def _error(self, what: str, remedy: str) -> ConfigError:
        return ConfigError(f"{self.keys.file}: security.keys: {what}; create them: {remedy}")
