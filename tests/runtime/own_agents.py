"""Agents such as a user may add, for the tests of deployments."""

from typing import Annotated, Literal

from agents.agent import Agent, Array, Body, Percepts


class Nudge(Agent):
    """Takes parameters of several kinds."""

    def __init__(
        self,
        body: Body,
        *,
        gain: float = 0.5,
        law: Literal["line", "fixed-step"] = "line",
        memory: Annotated[float, "s"] = 1.5,
        bounds: tuple[Annotated[float, "rad"], ...] = (),
        note: str | None = None,
        eager: bool = False,
    ) -> None:
        if gain <= 0:
            raise ValueError(f"gain: {gain:g} must be positive")
        if len(bounds) == 1:
            raise ValueError("one bound is none")
        if note == "fragile":
            raise KeyError(note)
        self.body, self.gain = body, gain

    def decide(self, percepts: Percepts) -> Array | None:
        return None


class Still(Agent):
    """Takes none."""

    def __init__(self, body: Body) -> None:
        self.body = body

    def decide(self, percepts: Percepts) -> Array | None:
        return None


class Unclear(Agent):
    """Wants what no file can hold."""

    def __init__(self, body: Body, *, friend: Agent) -> None:
        pass

    def decide(self, percepts: Percepts) -> Array | None:
        return None
