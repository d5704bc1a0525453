"""When a process has no more reason to live (rule 8). Pure: it is told what is heard, and when."""


class Life:
    """Judges from what was heard of the plant; a process of its own judges for each role.

    patience: it ends after so long without a plant [s]
    duration: the run ends at that plant time [s], None if it does not
    speed: how many times as fast as real time the plant runs
    now: when the process began [s], on the clock of all that follows
    """

    GRACE = 2.0  # [s] that a plant which is no longer heard may be late
    _TWICE = 2  # checks in a row, so that one corrupted time ends nothing

    def __init__(self, *, patience: float, duration: float | None, speed: float, now: float):
        self._patience = patience
        self._duration = duration
        self._speed = speed
        self._heard = now
        self._t = 0.0
        self._ever = False
        self._over = 0

    def plant_heard(self, t: float, now: float) -> None:
        """The plant said `now` [s] that its time is `t` [s]."""
        self._t, self._heard, self._ever = t, now, True

    @property
    def t(self) -> float:
        """Plant time last heard [s]."""
        return self._t

    def over(self, now: float) -> bool:
        """Tell whether the run has reached its end; to be asked a few times a second."""
        if self._duration is None:
            return False
        silent = now - self._heard
        late = self._t + (silent - self.GRACE) * self._speed if self._ever else 0.0
        self._over = self._over + 1 if max(self._t, late) >= self._duration - 1e-9 else 0
        return self._over >= self._TWICE

    def forlorn(self, now: float) -> str | None:
        """Return why it waits no longer, or None."""
        if now - self._heard <= self._patience:
            return None
        silence = "no plant was heard" if self._ever else "no plant was ever heard"
        return f"{silence} for {self._patience:g} s"
