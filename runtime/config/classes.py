"""Classes that a deployment names as `module:Class`, so that users add theirs beside ours."""

import importlib
import inspect
import pkgutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Generic, TypeVar

from runtime.config.kinds import Kind, Scope, Text
from runtime.config.reading import Field, parameters_of
from runtime.config.tree import ConfigError, YamlNode
from runtime.errors import nearest, valid_are

_T = TypeVar("_T")


@dataclass(frozen=True)
class ClassName(Generic[_T]):
    """A class that a deployment names, and its parameters.

    Attributes:
        name: As written, `module:Class`.
        load: Imports the module and returns the class.
        parameters: Its keyword-only parameters; None if it is not loaded, in a process of another
            role.
    """

    name: str
    load: Callable[[], Any] = field(compare=False, repr=False)
    parameters: Sequence[Field] | None = field(default=None, compare=False, repr=False)

    def __str__(self) -> str:
        return self.name

    @property
    def is_loaded(self) -> bool:
        """Whether this process has the class."""
        return self.parameters is not None

    def make(self, *positional: Any, **parameters: Any) -> _T:
        """Make an object of the class, or raise `ConfigError` if it is not loaded."""
        if not self.is_loaded:
            raise ConfigError("this deployment was loaded for another role, without this class")
        made: _T = self.load()(*positional, **parameters)
        return made

    def check(self, node: YamlNode, build: Callable[[], _T]) -> _T | None:
        """If it is loaded, return what `build` makes; its exceptions become errors in `node`."""
        try:
            return build() if self.is_loaded else None
        except Exception as error:  # a user's constructor may do anything
            if isinstance(error, ValueError):
                raise node.blame(error) from error
            raise node.error(f"{type(error).__name__}: {error}") from error


class ClassOf(Kind, frozen=True):
    """The name of a class that derives from `base`.

    Of a list of names it is the first whose module can be imported: others may need an extra that
    is not installed.
    """

    base: type[Any]
    role: str = ""  # that needs it; by default the one given beside it

    def read(self, node: YamlNode, scope: Scope) -> ClassName[Any]:
        """Read the name, and load the class unless only that of another role is wanted."""
        if node.shape is list:
            return self.read(self._first(node, scope), scope)
        name = Text(self.such_as, "a class", r"\w+(\.\w+)*:\w+").read(node, scope)
        load = partial(self._load, name, node, str(scope["modules"]))
        if scope["only_role"] not in (None, scope.get("role", self.role)):
            return ClassName(name, load)
        try:
            return ClassName(name, load, parameters_of(load()))
        except ConfigError:
            raise
        except (TypeError, NameError, ValueError) as error:
            raise node.error(f"{name} cannot be used in a file: {error}") from None

    def _first(self, node: YamlNode, scope: Scope) -> YamlNode:
        """Return the first name of a list whose module can be imported."""
        reason = node.error(f"is empty; name a class, such as [{self.such_as}]")
        for each in node.children.values():
            try:
                self._load(Text(self.such_as).read(each, scope), each, str(scope["modules"]))
                return each
            except ConfigError as error:
                if not isinstance(error.__cause__, ImportError):
                    raise  # of a name that is wrong, which no installation makes right
                reason = error
        raise reason

    def _load(self, name: str, node: YamlNode, folder: str) -> Callable[..., Any]:
        if folder not in sys.path:
            sys.path.append(folder)
        module_name, _, attribute = name.partition(":")
        try:
            module = importlib.import_module(module_name)
        except Exception as error:  # a module may do anything when it is imported
            missing = error.name if isinstance(error, ModuleNotFoundError) else None
            if missing is None or not f"{module_name}.".startswith(f"{missing}."):
                what = f"{type(error).__name__}: {error}"
                raise node.error(f"module {module_name} cannot be imported: {what}") from error
            ours = importlib.import_module(self.base.__module__.partition(".")[0])
            known = (m.name for m in pkgutil.iter_modules(ours.__path__, f"{ours.__name__}."))
            what = f"there is no module {module_name!r}, neither installed nor in {folder}"
            raise node.error(what + nearest(module_name, known)) from None
        valid: dict[str, type[Any]] = {n: c for n, c in vars(module).items() if self._fits(c)}
        if attribute not in valid:
            base = self.base.__name__
            derive = f"; derive one from {self.base.__module__}:{base}"
            hint = valid_are(attribute, valid) if valid else derive
            raise node.error(f"{module_name} has no {base} class {attribute!r}{hint}")
        return valid[attribute]

    def _fits(self, candidate: Any) -> bool:
        if not inspect.isclass(candidate) or not issubclass(candidate, self.base):
            return False
        return not inspect.isabstract(candidate) and not candidate.__name__.startswith("_")
