"""What a scripted person has before them: a robot that they see, and its buttons."""

from abc import ABC, abstractmethod

from studies.person.button_sets import Seen


class Controls(ABC):
    """A robot that is seen and its buttons, of which one is held at a time.

    Attributes:
        track: What was seen of the robot until now.
    """

    def __init__(self) -> None:
        self.track: list[Seen] = []

    @property
    @abstractmethod
    def presses(self) -> int:
        """How often something was pressed until now: a key, the switch, the screen."""

    @abstractmethod
    def hold(self, move: str) -> None:
        """Press the button of a move, with all that it takes to come to it."""

    @abstractmethod
    def let_go(self) -> None:
        """Let go of it."""

    @abstractmethod
    def holds(self, move: str) -> bool:
        """Tell whether it is still held, and nothing has ended that."""

    @abstractmethod
    def wait(self, seconds: float) -> None:
        """Look on for so long [s]."""
