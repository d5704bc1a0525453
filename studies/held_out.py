"""Cases of every kind for the mobile arm, drawn from a generator: what is tuned on is not reported.

Seeds 0 to 9 are for tuning, all others for reporting. A kind is one batch of robots that share a
period and a duration and differ in start, faults and goal, so that a kind takes seconds to run.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from agents.agent import Agent, Array, Goal, Percepts
from plant.plant import Commands
from studies.batch_faults import BatchFaults
from studies.lockstep import Trace, decide_all, true_motion
from studies.mobile import ARPH, BASE, HAND, PERIOD, POSTURE, VELOCITY, plant
from studies.mobile_reach import heights

TUNING = range(10)
"""Seeds of cases that a law may be tuned on."""
MID = 8.0
"""When joints break in mid-path [s]."""
GOOD, NEAR = 0.003, 0.010
"""Errors at the end that count as there, and as nearly there [m]."""
ALL = np.arange(-180.0, 180.0, 10.0), np.arange(-60.0, 151.0, 10.0), np.arange(-150.0, 151.0, 10.0)

Lead = Callable[[float], tuple[Array, Array]]
"""Where the goals (B, 3) [m] are at a time [s], and how fast they move (B, 3) [m/s]."""


class Kind(NamedTuple):
    """B cases that are run at once.

    Attributes:
        name: In words.
        q, base: (B, 6) and (B, 3) their starts.
        each: Their faults.
        lead: Their goals.
        duration: [s].
        judged: Last part of the run in which the largest error counts [s].
        pushed: (B,) turning speed forced on the platform from 6 to 6.5 s [rad/s].
        false: (B, 3) where the goal is said to be, once, at 6 s, off where it is [m].
    """

    name: str
    q: Array
    base: Array
    each: BatchFaults
    lead: Lead
    duration: float
    judged: float = 1.0
    pushed: Array | None = None
    false: Array | None = None

    def part(self, rows: npt.NDArray[np.int_] | slice) -> "Kind":
        """Some of them."""

        def lead(t: float) -> tuple[Array, Array]:
            place, velocity = self.lead(t)
            return place[rows], velocity[rows]

        each = BatchFaults(
            self.each.locked[rows], self.each.strength[rows], self.each.platform[rows],
            self.each.since[rows],
        )  # fmt: skip
        pushed = None if self.pushed is None else self.pushed[rows]
        false = None if self.false is None else self.false[rows]
        return self._replace(
            q=self.q[rows], base=self.base[rows], each=each, lead=lead, pushed=pushed, false=false
        )


def play(kind: Kind, agents: Mapping[str, Agent], period: float = PERIOD) -> Trace:
    """Run all cases of a kind at once."""
    robots = plant(kind.q, kind.base, each=kind.each, period=period)
    ticks: list[tuple[Array, ...]] = []
    every = max(round(PERIOD / period), 1)
    for tick in range(round(kind.duration / period) + 1):
        t, q, qd, base, base_velocity, hand, _ = map(np.asarray, true_motion(robots))
        position, velocity = kind.lead(float(t))
        if tick % every == 0:
            ticks.append((t, hand, position, q, qd, base, base_velocity))
        sent = position
        if kind.false is not None and abs(t - 6.0) < period / 2:
            sent = position + kind.false
        goal = Goal(sent, velocity, float(t), float(t) + 10.0)
        commands = decide_all(agents, Percepts.of(robots.read(), goal), q.shape)
        if kind.pushed is not None and 6.0 <= t < 6.5:
            drive = np.array(commands.base)
            drive[:, 1] = np.where(kind.pushed != 0, kind.pushed, drive[:, 1])
            commands = Commands(commands.joints, drive)
        robots.write(commands)
        robots.step()
    return Trace(*(np.stack(column) for column in zip(*ticks, strict=True)))


def line(velocity: Array, begin: Array | float = 0.0, end: Array | float = np.inf) -> Lead:
    """Straight lines from the hand's start at `velocity` (B, 3) [m/s], between two times (B,)."""

    def lead(t: float) -> tuple[Array, Array]:
        gone = np.clip(t, begin, end) - begin
        moves = np.broadcast_to((t >= begin) & (t < end), velocity.shape[:1])
        place = HAND + velocity * np.broadcast_to(gone, velocity.shape[:1])[:, None]
        return place, velocity * moves[:, None]

    return lead


def standing(places: Array) -> Lead:
    """Goals that stand at `places` (B, 3) [m]."""
    return lambda t: (places, np.zeros_like(places))


def circling(size: Array, speed: Array, eight: Array, way: Array, turn: Array) -> Lead:
    """Circles, or figures of eight, of `size` (B,) [m] through the hand's start, in chords.

    `speed` is in m/s, `way` +1 or -1 the sense, `turn` the direction of the first tangent [rad].
    """

    def place(t: Array) -> Array:
        phase = speed * t / size
        # an eight is two circles that touch; each lap of one is followed by one of the other
        second = (np.floor(phase / (2 * np.pi)) % 2 == 1) & eight
        side = np.where(second, -way, way)
        x, y = size * np.sin(phase), side * size * (1 - np.cos(phase))
        cosine, sine = np.cos(turn), np.sin(turn)
        flat = np.stack([cosine * x - sine * y, sine * x + cosine * y, 0 * x], axis=-1)
        found: Array = HAND + flat
        return found

    def lead(t: float) -> tuple[Array, Array]:
        chord = 2 * np.pi * size / speed / 100
        since = np.floor(t / chord + 1e-9) * chord
        velocity = (place(since + chord) - place(since)) / chord[:, None]
        return place(since) + velocity * (t - since)[:, None], velocity

    return lead


def waypoints(points: Array, speed: Array, rest: float) -> Lead:
    """Straight legs from the hand's start through `points` (B, P, 3) [m], with a rest at each."""
    count = len(points)
    whole = np.concatenate([np.tile(HAND, (count, 1, 1)), points], axis=1)
    ways = np.diff(whole, axis=1)
    lasts = np.maximum(np.linalg.norm(ways, axis=2) / speed[:, None], 1e-6)
    begins = np.cumsum(lasts + rest, axis=1) - lasts

    def lead(t: float) -> tuple[Array, Array]:
        share = np.clip((t - begins) / lasts, 0.0, 1.0)
        moves = (t >= begins) & (t < begins + lasts)
        place = HAND + (ways * share[..., None]).sum(axis=1)
        return place, (ways / lasts[..., None] * moves[..., None]).sum(axis=1)

    return lead


def with_locks(locks: Array, since: Array | float, slow: Array | float = 1.0) -> BatchFaults:
    """Joints 1 to 3 locked at `locks` (B, 3) [rad], and a platform at a share of its speed."""
    each = BatchFaults.none(ARPH, len(locks))
    each.locked[:, :3] = locks
    each.since[:] = since
    each.platform[:] = slow
    return each


def starts(locks: Array, since: Array | float) -> Array:
    """(B, 6) the start, with the joints that are locked from the start at their angles [rad]."""
    q = np.tile(POSTURE, (len(locks), 1))
    at_once = ~np.isnan(locks) & (np.broadcast_to(since, len(locks)) == 0)[:, None]
    q[:, :3] = np.where(at_once, locks, q[:, :3])
    return q


def locked(name: str, locks: Array, since: Array | float, lead: Lead, duration: float) -> Kind:
    """Make a kind of cases that start as in Table 1."""
    base = np.tile(BASE, (len(locks), 1))
    return Kind(name, starts(locks, since), base, with_locks(locks, since), lead, duration)


def singles() -> Array:
    """(89, 3) each of joints 1 to 3 at every 10 deg of its range, NaN for the others [rad]."""
    rows = [(joint, angle) for joint in range(3) for angle in ALL[joint]]
    locks = np.full((len(rows), 3), np.nan)
    for row, (joint, angle) in enumerate(rows):
        locks[row, joint] = np.radians(angle)
    return locks


def can(kind: Kind, locks: Array, velocity: Array) -> npt.NDArray[np.bool_]:
    """Whether a plan is known to follow lines at `velocity` (B, 3) from the faults on."""
    from agents.paths import Line
    from studies.feasible_plans import Since, earliest
    from studies.lockstep import run
    from studies.mobile import msma

    found = np.zeros(len(locks), dtype=bool)
    for one in np.unique(velocity, axis=0):
        for at in np.unique(kind.each.since):
            x, y, z = HAND.tolist()
            vx, vy, vz = one.tolist()
            path = Line(start=(x, y, z), velocity=(vx, vy, vz), duration=kind.duration)
            nominal = run(plant(), msma(), path.piece, float(at) + PERIOD)
            rows = (velocity == one).all(axis=1) & (kind.each.since == at)
            free = np.isnan(locks)
            for kindred in np.unique(free[rows], axis=0):
                some = np.nonzero(rows & (free == kindred).all(axis=1))[0]
                if kindred.all():
                    found[some] = True
                    continue
                q = starts(locks[some], 0.0)[:, :3] if at == 0 else None
                q = np.tile(nominal.q[-2, :3], (len(some), 1)) if q is None else q
                base = np.tile(nominal.base[-2] if at else BASE, (len(some), 1))
                few = 24 if kindred.sum() == 1 else 1
                for rows_now in np.array_split(np.arange(len(some)), -(-len(some) // few)):
                    answer = earliest(
                        ARPH, locks[some[rows_now]], path.piece(0.0),
                        Since(float(at), q[rows_now], base[rows_now]), kind.duration,
                    )  # fmt: skip
                    found[some[rows_now]] = np.isfinite(answer) & (answer < kind.duration - 4.0)
    return found


def same_height(locks: Array, low: Array, high: Array) -> npt.NDArray[np.bool_]:
    """Whether arms with `locks` (B, 3) have all heights between two (B,) [m]."""
    least, most = heights(locks)
    rigid = ~np.isnan(locks[:, 1:]).any(axis=1)
    fine: npt.NDArray[np.bool_] = (least + 0.02 <= low) & (high <= most - 0.02) & ~rigid
    return fine


class Figures(NamedTuple):
    """How the cases went, (B,) each.

    Attributes:
        final: Largest error of the last part [m].
        median: Middle error of the last fifth of the run [m].
        settled: When the error came under `GOOD` for good [s]; inf for never.
        turned: How far the platform turned in all [rad].
        spun: How far it turned one way and did not turn back [rad].
        jerk: Of the platform's middle [m/s3].
        elbow: Least of joint 3 from straight [rad].
        late: How far it turned in the last 5 s [rad].
    """

    final: Array
    median: Array
    settled: Array
    turned: Array
    spun: Array
    jerk: Array
    elbow: Array
    late: Array


def figures(kind: Kind, trace: Trace) -> Figures:
    """Judge a kind."""
    error = trace.error
    after = trace.t >= trace.t[-1] - kind.judged - 1e-9
    bad = error > GOOD
    last = len(error) - 1 - np.argmax(bad[::-1], axis=0)
    settled = np.where(bad.any(axis=0), trace.t[np.minimum(last + 1, len(error) - 1)], 0.0)
    settled = np.where(bad[-1], np.inf, settled)
    heading = trace.base[..., 2]
    jerk = np.diff(trace.base[..., :2], n=3, axis=0) / PERIOD**3
    late = trace.t >= trace.t[-1] - 5.0
    return Figures(
        error[after].max(axis=0),
        np.median(error[-len(error) // 5 :], axis=0),
        settled,
        np.abs(np.diff(heading, axis=0)).sum(axis=0),
        heading.max(axis=0) - heading.min(axis=0),
        np.sqrt((jerk**2).sum(axis=-1).mean(axis=0)),
        np.abs(trace.q[..., 2]).min(axis=0),
        np.abs(np.diff(heading[late], axis=0)).sum(axis=0),
    )


def drawn(seed: int, count: int = 16) -> list[tuple[Kind, Array]]:
    """Cases of every kind from a generator's seed, each with its locks (B, 3).

    Only such as the arm has the heights for, which for all but lines is what decides.
    """
    rng = np.random.default_rng([18, seed])
    found: list[tuple[Kind, Array]] = []

    def locks_of(how: str, since: Array) -> Array:
        locks = np.full((count, 3), np.nan)
        for row in range(count):
            pick = {"free": 0, "one": 1, "two": 2}[how]
            joints = rng.permutation(3)[:pick]
            if how == "two" and set(joints) == {1, 2}:
                joints = np.array([0, rng.integers(1, 3)])
            for joint in joints:
                limits = [(-180.0, 180.0), (-60.0, 150.0), (-150.0, 150.0)][joint]
                locks[row, joint] = np.radians(rng.uniform(*limits))
        return locks

    for how in ("free", "one", "two"):
        for what in ("line", "standing", "circle", "eight", "waypoints"):
            since = np.where(rng.random(count) < 0.5, 0.0, MID)
            speed = np.linalg.norm(VELOCITY) * np.exp(rng.uniform(np.log(0.25), np.log(1.5), count))
            course = rng.uniform(-np.pi, np.pi, count)
            # draws anew until all heights are to be had
            locks = np.full((count, 3), np.nan)
            low, high = np.full(count, HAND[2]), np.full(count, HAND[2])
            rise = rng.uniform(-0.3, 0.3, count)
            points = HAND + np.concatenate(
                [rng.uniform(-1.5, 1.5, (count, 3, 2)), rng.uniform(-0.3, 0.3, (count, 3, 1))], -1
            )
            radius = 1.5 * np.sqrt(rng.random(count))
            places = HAND + np.stack(
                [radius * np.cos(course), radius * np.sin(course), rng.uniform(-0.5, 0.5, count)], 1
            )
            velocity = speed[:, None] * np.stack(
                [np.cos(course) * np.cos(rise), np.sin(course) * np.cos(rise), np.sin(rise)], 1
            )
            lead: Lead
            duration = 40.0
            if what == "line":
                lead, duration = line(velocity), 24.0
                end = HAND[2] + velocity[:, 2] * duration
                velocity[:, 2] *= np.where((end < 0.1) | (end > 1.6), 0.0, 1.0)
                end = HAND[2] + velocity[:, 2] * duration
                low, high = np.minimum(end, HAND[2]), np.maximum(end, HAND[2])
            elif what == "standing":
                lead = standing(places)
                low = high = places[:, 2]
            elif what == "waypoints":
                lead = waypoints(points, speed, 1.0)
                low = np.minimum(points[..., 2].min(axis=1), HAND[2])
                high = np.maximum(points[..., 2].max(axis=1), HAND[2])
            else:
                size = rng.uniform(0.4, 1.2, count)
                lead = circling(size, speed, np.full(count, what == "eight"),
                                np.where(rng.random(count) < 0.5, 1.0, -1.0), course)  # fmt: skip
            wanted = np.full(count, how != "free")
            for _ in range(200):
                locks = np.where(wanted[:, None], locks_of(how, since), locks)
                wanted &= ~same_height(locks, low, high)
                if not wanted.any():
                    break
            kind = locked(f"{how}, {what}", locks, since, lead, duration)
            if what == "line" and how != "free":
                kind = kind.part(np.nonzero(can(kind, locks, velocity))[0])
            elif what != "line":
                kind = kind._replace(judged=10.0 if what in ("circle", "eight") else 1.0)
            found.append((kind, locks))
    return found
