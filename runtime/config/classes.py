"""Classes that a deployment names as `module:Class`, so that users add theirs beside ours."""

import importlib
import inspect
import pkgutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar, Self

from agents.agent import Agent
from agents.paths import Path
from plant.plant import Plant
from runtime.config.kinds import Pattern, Scope, Text
from runtime.config.reading import Field, parameters_of
from runtime.config.tree import ConfigError, YamlNode
from runtime.errors import nearest, valid_are
from runtime.processes.node import Node
from runtime.wire.topics import GOAL_SOURCE, PLANT


@dataclass(frozen=True)
class ClassName:
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

    base: ClassVar[type[Any]]
    such_as: ClassVar[str]
    role: ClassVar[str] = ""  # the role that needs the class; empty for the role given beside it

    @classmethod
    def from_node(cls, node: YamlNode, scope: Scope) -> Self:
        """Read the name, and load the class unless only that of another role is wanted."""
        pattern = Pattern(r"\w+(\.\w+)*:\w+", "a class", cls.such_as)
        name = Text(pattern).read(node, scope)
        load = partial(cls._load, name, node, str(scope["modules"]))
        if scope["only_role"] not in (None, scope.get("role", cls.role)):
            return cls(name, load)
        try:
            return cls(name, load, parameters_of(load()))
        except (TypeError, NameError, ValueError) as error:
            if isinstance(error, ConfigError):
                raise
            raise node.error(f"{name} cannot be used in a file: {error}") from None

    @classmethod
    def _load(cls, name: str, node: YamlNode, folder: str) -> Callable[..., Any]:
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
            ours = importlib.import_module(cls.base.__module__.partition(".")[0])
            known = (m.name for m in pkgutil.iter_modules(ours.__path__, f"{ours.__name__}."))
            what = f"there is no module {module_name!r}, neither installed nor in {folder}"
            raise node.error(what + nearest(module_name, known)) from None
        valid: dict[str, type[Any]] = {n: c for n, c in vars(module).items() if cls._fits(c)}
        if attribute not in valid:
            base = cls.base.__name__
            derive = f"; derive one from {cls.base.__module__}:{base}"
            hint = valid_are(attribute, valid) if valid else derive
            raise node.error(f"{module_name} has no {base} class {attribute!r}{hint}")
        return valid[attribute]

    @classmethod
    def _fits(cls, candidate: Any) -> bool:
        if not inspect.isclass(candidate) or not issubclass(candidate, cls.base):
            return False
        return not inspect.isabstract(candidate) and not candidate.__name__.startswith("_")

    @property
    def is_loaded(self) -> bool:
        """Whether this process has the class."""
        return self.parameters is not None

    def make(self, *positional: Any, **parameters: Any) -> Any:
        """Make an object of the class, or raise `ConfigError` if it is not loaded."""
        if not self.is_loaded:
            raise ConfigError("this deployment was loaded for another role, without this class")
        return self.load()(*positional, **parameters)

    def check(self, node: YamlNode, build: Callable[[], Any]) -> None:
        """If it is loaded, run `build`; turn its exceptions into errors at the values in `node`."""
        try:
            if self.is_loaded:
                build()
        except Exception as error:  # a user's constructor may do anything
            name, _, what = str(error).partition(": ")
            if isinstance(error, ValueError) and name in node.children:
                raise node.children[name].error(what) from error
            kind = "" if isinstance(error, ValueError) else f"{type(error).__name__}: "
            raise node.error(f"{kind}{error}") from error

    def __str__(self) -> str:
        return self.name


class AgentClass(ClassName):
    """A class of agents."""

    base = Agent
    such_as = "agents.joint:JointAgent"


class PathClass(ClassName):
    """A class of paths."""

    base = Path
    such_as = "agents.paths:Line"
    role = GOAL_SOURCE


class PlantClass(ClassName):
    """A class of plants."""

    base = Plant
    such_as = "plant.kinematic:KinematicPlant"
    role = PLANT


class NodeClass(ClassName):
    """A class of nodes."""

    base = Node
    such_as = "mine:Camera"
