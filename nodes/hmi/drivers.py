"""Who drives: one viewer at a time, and who asks to. Pure: times are passed in.

The first press takes it; it is free after a while without a press, when the driver leaves, and
after a stop. Anybody may stop, which is not decided here.
"""

from typing import NamedTuple

_ASKED = 10.0  # [s] for which a question is shown


class Change(NamedTuple):
    """What everybody is to be shown: a key of the words, and the viewer whom it is about."""

    key: str
    viewer: int | None = None


class Drivers:
    """Who drives and who asks to; `idle` [s] is the time after which nobody does any more.

    Attributes:
        driver: The viewer who drives; None if nobody does.
        asking: The viewer who asks to; None if nobody does.
    """

    def __init__(self, idle: float) -> None:
        self.driver: int | None = None
        self.asking: int | None = None
        self._idle = idle
        self._active = self._asked = 0.0  # when the driver last pressed, when it was asked for

    def take(self, viewer: int, now: float) -> bool:
        """Drive, if nobody else does; return whether that viewer drives. To be called while so."""
        self.look(now)
        if self.driver not in (None, viewer):
            return False
        self.driver, self._active = viewer, now
        if self.asking == viewer:
            self.asking = None
        return True

    def ask(self, viewer: int, now: float) -> Change | None:
        """Ask to drive, which is granted at once if nobody does."""
        self.look(now)
        if self.driver == viewer:
            return None
        if self.driver is None:
            self.take(viewer, now)
            return Change("drive.granted", viewer)
        if self.asking not in (None, viewer):
            return None  # one question at a time
        self.asking, self._asked = viewer, now
        return Change("drive.asked", viewer)

    def answer(self, viewer: int, grant: bool, now: float) -> Change | None:
        """Take the driver's answer to who asks, or the driver's leave; None from anybody else."""
        if viewer != self.driver:
            return None
        asking, self.asking = self.asking, None
        if not grant:
            return Change("drive.refused", asking) if asking is not None else None
        self.driver = asking
        self._active = now
        return Change("drive.free") if asking is None else Change("drive.granted", asking)

    def revoke(self) -> Change | None:
        """Let nobody drive: after a stop."""
        driver, self.driver, self.asking = self.driver, None, None
        return None if driver is None else Change("drive.free")

    def leave(self, viewer: int) -> Change | None:
        """Note that a viewer is gone."""
        if self.asking == viewer:
            self.asking = None
        if self.driver != viewer:
            return None
        self.driver = None
        return Change("drive.free")

    def look(self, now: float) -> Change | None:
        """Free it after the idle time, and forget a question that was not answered."""
        if self.asking is not None and now - self._asked > _ASKED:
            self.asking = None
        if self.driver is None or now - self._active <= self._idle:
            return None
        self.driver = None
        return Change("drive.free")
