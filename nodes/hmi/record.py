"""The record of what happened, and which processes there are, as engineers see them."""

from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Mapping

from msgspec import Struct

from nodes.hmi.protocol.outgoing import Happened, Happening, ProcessInfo
from runtime.processes.log_writer import LogWriter
from runtime.watching.roster import Row
from runtime.wire.operator_messages import OperatorState

_KEPT = 200
_SILENT = 3.0  # [s] without diagnostics, which come once a second, after which a process hangs


class Record:
    """Notes what happened, in the log and for all viewers.

    Attributes:
        lines: The last of it.
    """

    def __init__(self, log: LogWriter, post: Callable[[int | None, Struct], None]) -> None:
        self.lines: deque[Happening] = deque(maxlen=_KEPT)
        self._log, self._post = log, post
        self._operator: OperatorState | None = None

    def note(self, t: float, key: str, **params: str | float | int) -> None:
        """Note something at plant time `t` [s]."""
        line = Happening(round(t, 3), key, params)
        self.lines.append(line)
        self._log.write(t, "page", key=key, params=params)
        self._post(None, Happened(line))

    def look(self, operator: OperatorState | None) -> None:
        """Note what has changed of the robot's gate."""
        before = self._operator
        if operator is None:
            return
        self._operator = operator
        if before is None:
            return
        if operator.halted and not before.halted:
            self.note(operator.t, "gate.halted", by=operator.halted_by)
        elif before.halted and not operator.halted:
            self.note(operator.t, "gate.released")
        if operator.mode != before.mode:
            self.note(operator.t, "gate.mode", mode=operator.mode)
        if operator.limit != before.limit:
            self.note(operator.t, "gate.limit", limit=operator.limit)


class ProcessTable:
    """The processes by role, how often each was started again, and what changed."""

    def __init__(self, roles: Iterable[str]) -> None:
        self._roles = tuple(roles)
        self._incarnations = defaultdict[str, set[int]](set)
        self._states: dict[str, str] = {}
        self._heard: dict[int, tuple[int, float]] = {}  # the last diag of each, and when it came

    def look(self, rows: Iterable[Row], now: float) -> tuple[ProcessInfo, ...]:
        """Return all of them `now` [s]."""
        by_role: dict[str, Row] = {}
        for row in rows:
            if row.alive:
                self._incarnations[row.role].add(row.incarnation)
            if row.alive or row.role not in by_role:
                by_role[row.role] = row
        extra = [role for role in by_role if role not in self._roles]
        return tuple(self._info(role, by_role.get(role), now) for role in (*self._roles, *extra))

    def _info(self, role: str, row: Row | None, now: float) -> ProcessInfo:
        restarts = max(len(self._incarnations[role]) - 1, 0)
        if row is None:
            return ProcessInfo(role, "none", "", "", None, None, None, restarts, 0)
        diag = row.diag
        if diag is not None and self._heard.get(row.incarnation, (-1, 0.0))[0] != diag.n:
            self._heard[row.incarnation] = (diag.n, now)
        heard = self._heard.get(row.incarnation, (0, row.since))[1]
        state = "gone" if not row.alive else "silent" if now - heard > _SILENT else "runs"
        return ProcessInfo(
            role,
            "gone" if state == "gone" else "silent" if state == "silent" else "runs",
            "" if diag is None else diag.state,
            "" if diag is None else diag.host,
            None if diag is None else diag.pid,
            None if diag is None else round(diag.rate, 1),
            None if row.answer is None else row.answer.median,
            restarts,
            row.refused,
        )

    def changes(self, infos: Iterable[ProcessInfo]) -> Mapping[str, str]:
        """Return the words' key for each role that has come, gone or fallen silent since."""
        keys = {"runs": "process.came", "silent": "process.silent", "gone": "process.gone"}
        found = {}
        for one in infos:
            before, self._states[one.role] = self._states.get(one.role), one.state
            if before not in (None, "none", one.state) and one.state in keys:
                found[one.role] = keys[one.state]
        return found
