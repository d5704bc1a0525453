"""Work that is done in parts, so that an agent answers in between."""

from collections.abc import Generator
from itertools import count
from typing import TypeVar

T = TypeVar("T")
InParts = Generator[None, None, T]
"""What is worked out in parts: one at each `next`, with the outcome after the last."""


def advance(work: InParts[T], parts: int | None = None) -> T | None:
    """Do some parts of the work.

    Args:
        work: What is begun already, or not.
        parts: How many [], none for all that are left.

    Returns:
        The outcome, None as long as some are left.
    """
    for _ in count() if parts is None else range(parts):
        try:
            next(work)
        except StopIteration as done:
            return done.value  # type: ignore[no-any-return]
    return None
