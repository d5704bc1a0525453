"""Who moves the robot, by tables of what happens and by random orders of events."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.gate.gate import FASTEST, LEASE, SLOWS, STALE, Gate, GateError
from runtime.wire.operator_messages import JogMessage

PAGE, OTHER = 7, 8
SOON = 0.05  # [s] from one message of a press to the next
Step = Callable[[Gate, float], Any]


def jog(
    press: int, mode: str = "shared", *, by: int = PAGE, held: bool = True, behind: float = 0.0
) -> Step:
    message = JogMessage(0.0, by=by, n=1, press=press, mode=mode, held=held)  # type: ignore[arg-type]
    return lambda gate, now: gate.jog(message, now, behind)


def choose(mode: str, limit: float | None = None) -> Step:
    return lambda gate, now: gate.choose(mode, limit)


def halt(by: str = "somebody") -> Step:
    return lambda gate, now: gate.halt(by)


def release() -> Step:
    return lambda gate, now: gate.release()


def resume() -> Step:
    return lambda gate, now: gate.resume(now)


def obeyed(gate: Gate, now: float) -> str:
    """Return who moves the robot: agents, a page by its press, or nobody."""
    if gate.mode == "automatic":
        return "agents"
    held = gate.held(now)
    return "nobody" if held is None else f"{held.by}:{held.press}"


HISTORIES: dict[str, tuple[list[tuple[float, Step]], str]] = {
    "it starts as it is told": ([], "nobody"),
    "choosing automatic": ([(0.0, choose("automatic"))], "agents"),
    "choosing shared starts nothing": ([(0.0, choose("shared"))], "nobody"),
    "choosing manual starts nothing": ([(0.0, choose("manual"))], "nobody"),
    "a press at rest": ([(0.0, jog(1))], "nobody"),
    "a press": ([(0.0, choose("shared")), (0.0, jog(1))], "7:1"),
    "a press for manual": ([(0.0, choose("manual")), (0.0, jog(1, "manual"))], "7:1"),
    "a press for another mode": ([(0.0, choose("manual")), (0.0, jog(1))], "nobody"),
    "a press let go": (
        [(0.0, choose("shared")), (0.0, jog(1)), (SOON, jog(1, held=False))],
        "nobody",
    ),
    "a press that goes on after it was let go": (
        [(0.0, choose("shared")), (0.0, jog(1)), (SOON, jog(1, held=False)), (SOON, jog(1))],
        "nobody",
    ),
    "the next press": (
        [(0.0, choose("shared")), (0.0, jog(1)), (SOON, jog(1, held=False)), (SOON, jog(2))],
        "7:2",
    ),
    "a press renewed": ([(0.0, choose("shared")), (0.0, jog(1)), (0.9 * LEASE, jog(1))], "7:1"),
    "a press that was silent for too long": (
        [(0.0, choose("shared")), (0.0, jog(1)), (1.1 * LEASE, jog(1)), (0.0, jog(1))],
        "nobody",
    ),
    "a press from before the mode was chosen": (
        [(0.0, jog(1)), (SOON, choose("shared")), (SOON, jog(1))],
        "nobody",
    ),
    "the mode chosen again while something is held": (
        [(0.0, choose("shared")), (0.0, jog(1)), (SOON, choose("shared", 0.1))],
        "7:1",
    ),
    "another mode chosen while something is held, and back": (
        [
            (0.0, choose("shared")),
            (0.0, jog(1)),
            (SOON, choose("manual")),
            (SOON, choose("shared")),
            (SOON, jog(1)),
        ],
        "nobody",
    ),
    "a second page presses while the first holds": (
        [(0.0, choose("shared")), (0.0, jog(1)), (SOON, jog(1, by=OTHER))],
        "7:1",
    ),
    "a second page went on pressing until the first let go": (
        [
            (0.0, choose("shared")),
            (0.0, jog(1)),
            (SOON, jog(1, by=OTHER)),
            (SOON, jog(1, held=False)),
            (SOON, jog(1, by=OTHER)),
        ],
        "nobody",
    ),
    "a second page presses anew after the first let go": (
        [
            (0.0, choose("shared")),
            (0.0, jog(1)),
            (SOON, jog(1, held=False)),
            (SOON, jog(1, by=OTHER)),
        ],
        "8:1",
    ),
    "the page was revived": (
        [(0.0, choose("shared")), (0.0, jog(5)), (2 * LEASE, jog(1, by=OTHER))],
        "8:1",
    ),
    "a hung page goes on after another was revived": (
        [
            (0.0, choose("shared")),
            (0.0, jog(5)),
            (2 * LEASE, jog(1, by=OTHER)),
            (SOON, jog(1, by=OTHER, held=False)),
            (SOON, jog(5)),
        ],
        "nobody",
    ),
    "a press on an old picture": (
        [(0.0, choose("shared")), (0.0, jog(1, behind=1.1 * STALE)), (SOON, jog(1))],
        "nobody",
    ),
    "the picture grows old while something is held": (
        [(0.0, choose("shared")), (0.0, jog(1)), (SOON, jog(1, behind=1.1 * STALE)), (0.0, jog(1))],
        "nobody",
    ),
    "a press on the picture of another plant": (
        [(0.0, choose("shared")), (0.0, jog(1, behind=-1.0))],
        "nobody",
    ),
    "what arrives as the plant goes on after it stood still": (
        [(0.0, choose("shared")), (5.0, resume()), (0.0, jog(1)), (SOON, jog(1))],
        "nobody",
    ),
    "a press some time after the plant stood still": (
        [(0.0, choose("shared")), (5.0, resume()), (2 * LEASE, jog(1))],
        "7:1",
    ),
    "halted in automatic": ([(0.0, choose("automatic")), (0.0, halt())], "nobody"),
    "halted while something is held": (
        [(0.0, choose("shared")), (0.0, jog(1)), (SOON, halt()), (SOON, jog(1)), (0.0, jog(2))],
        "nobody",
    ),
    "released": ([(0.0, choose("automatic")), (0.0, halt()), (1.0, release())], "nobody"),
    "released while something is held": (
        [(0.0, choose("shared")), (0.0, halt()), (0.0, jog(1)), (SOON, release()), (0.0, jog(1))],
        "nobody",
    ),
    "halted twice, released once": (
        [(0.0, halt()), (0.0, halt()), (0.0, release()), (0.0, choose("automatic"))],
        "agents",
    ),
    "released without a halt": ([(0.0, choose("automatic")), (0.0, release())], "agents"),
}


@pytest.mark.parametrize("name", HISTORIES)
def test_what_happened_says_who_moves_the_robot(name: str) -> None:
    steps, who = HISTORIES[name]
    gate, now = Gate("rest"), 100.0
    for later, act in steps:
        now += later
        act(gate, now)
    assert obeyed(gate, now) == who


def test_a_deployment_without_a_page_begins_in_automatic() -> None:
    assert obeyed(Gate(), 0.0) == "agents"


def test_who_halted_first_is_named_until_the_release() -> None:
    gate = Gate()
    gate.halt("a tool")
    gate.halt("a page")
    assert gate.state(1.0, 0.0).halted_by == "a tool"
    gate.release()
    state = gate.state(1.0, 0.0)
    assert (state.halted, state.halted_by, state.mode) == (False, "", "rest")


@pytest.mark.parametrize(
    ("mode", "limit", "why"),
    [
        ("fast", None, "no mode 'fast'; valid are rest, automatic, shared, manual"),
        ("shared", 0.3, "a limit of 0.3 m/s"),
        ("shared", 0.0, "a limit of 0 m/s"),
        ("shared", float("nan"), "a limit of nan m/s"),
    ],
)
def test_a_mode_that_there_is_not_is_refused(mode: str, limit: float | None, why: str) -> None:
    gate = Gate()
    with pytest.raises(GateError, match=why):
        gate.choose(mode, limit)
    assert gate.mode == "automatic"
    assert gate.limit == FASTEST


def test_no_mode_can_be_chosen_while_it_is_halted() -> None:
    gate = Gate(halted_by="the plant before")
    with pytest.raises(GateError, match="halted by the plant before: release it first"):
        gate.choose("automatic")
    assert gate.mode == "rest"


def test_a_limit_stays_until_another_is_chosen() -> None:
    gate = Gate()
    gate.choose("shared", 0.1)
    gate.choose("manual")
    assert gate.state(0.0, 0.0).limit == 0.1


@pytest.mark.parametrize(
    ("age", "share"),
    [(0.0, 1.0), (SLOWS, 1.0), ((SLOWS + LEASE) / 2, 0.5), (LEASE, 0.0), (2 * LEASE, 0.0)],
)
def test_a_press_slows_down_as_its_last_message_grows_old(age: float, share: float) -> None:
    gate = Gate("shared")
    jog(1)(gate, 0.0)
    assert gate.speed_share(age) == pytest.approx(share)


@pytest.mark.parametrize("period", [0.001, 0.02, 0.06, 0.1])
@pytest.mark.parametrize("phase", [0.0, 0.3, 0.6, 0.9])
def test_a_hand_of_150_mm_a_second_goes_less_than_30_mm_on(period: float, phase: float) -> None:
    """From when the last message arrived, between two turns of the control loop."""
    gate = Gate("shared", period=period)
    jog(1)(gate, 0.0)
    turns = [(phase + n) * period for n in range(int(LEASE / period) + 2)]
    moving = phase * period + sum(period * gate.speed_share(turn) for turn in turns)
    assert 0.15 * moving <= 0.026
    assert gate.speed_share(turns[-1]) == 0.0


def test_why_a_press_moves_nothing_is_said() -> None:
    gate = Gate("shared")
    jog(1)(gate, 0.0)
    jog(1, by=OTHER)(gate, SOON)
    assert gate.state(0.0, SOON).why == "another page drives"
    assert gate.state(0.0, 1.0).why == "its messages stopped: press again"
    jog(2)(gate, 1.0)
    assert gate.state(0.0, 1.0).why == ""


def test_the_path_pauses_outside_of_automatic_mode_and_the_task_ends_in_rest() -> None:
    gate = Gate("automatic", rest_after=2.0)
    gate.pass_time(1.0)
    gate.choose("manual")
    gate.pass_time(5.0)
    gate.choose("automatic")
    assert gate.paused == 5.0
    gate.pass_time(1.0)
    assert gate.mode == "rest"
    gate.choose("automatic")  # once more, which a person has chosen
    gate.pass_time(9.0)
    assert (gate.mode, gate.paused) == ("automatic", 5.0)


def test_a_press_that_says_another_mode_than_it_was_made_in_is_over() -> None:
    gate = Gate("shared")
    jog(8, "shared")(gate, 0.0)
    assert gate.held(0.0) is not None
    jog(8, "manual")(gate, 0.05)
    assert gate.held(0.05) is None
    jog(8, "shared")(gate, 0.1)
    assert gate.held(0.1) is None, "it is spent"


MODES = st.sampled_from(["rest", "automatic", "shared", "manual"])
PRESSES = st.builds(
    lambda *args: ("jog", *args),
    st.integers(0, 3),
    st.sampled_from(["shared", "manual"]),
    st.sampled_from([PAGE, OTHER]),
    st.booleans(),
    st.sampled_from([-1.0, 0.0, 1.0]),
)
EVENTS = st.one_of(
    PRESSES,
    st.tuples(st.just("choose"), MODES),
    st.sampled_from([("halt",), ("release",), ("resume",), ("nothing",)]),
)


@given(st.lists(st.tuples(st.sampled_from([0.0, 0.05, 0.2, 0.3]), EVENTS), max_size=40), MODES)
def test_nothing_moves_without_a_living_press_or_after_a_halt(
    history: list[tuple[float, tuple[Any, ...]]], start: Any
) -> None:
    """Beside the gate goes a record of who said what when, by which each motion is judged."""
    gate, now = Gate(start), 0.0
    halted, deaf_until = False, -1.0
    first: dict[tuple[int, int], float] = {}  # when each press was first heard of,
    last: dict[tuple[int, int], float] = {}  # and last, in time and in its mode
    ended: set[tuple[int, int]] = set()
    for later, (kind, *args) in history:
        now += later
        ended |= {press for press, heard in last.items() if now - heard > LEASE}
        if kind == "jog":
            press, mode, by, held, behind = args
            jog(press, mode, by=by, held=held, behind=behind)(gate, now)
            first.setdefault((by, press), now)
            if held and behind == 0.0 and mode == gate.mode and now > deaf_until:
                last[by, press] = now
            else:
                ended.add((by, press))
        elif kind == "choose":
            before = gate.mode
            if halted:
                with pytest.raises(GateError):
                    gate.choose(args[0])
            else:
                gate.choose(args[0])
            if gate.mode != before:
                ended |= first.keys()
        elif kind == "halt":
            gate.halt("somebody")
            halted, ended = True, ended | first.keys()
        elif kind == "release":
            gate.release()
            assert not halted or gate.mode == "rest"
            halted = False
        elif kind == "resume":
            gate.resume(now)
            ended, deaf_until = ended | first.keys(), now + LEASE
        assert (gate.halted_by is not None) == halted
        assert not (halted and gate.mode != "rest")
        driver = gate.held(now)
        assert driver is None or gate.mode in ("shared", "manual")
        assert (gate.speed_share(now) > 0) <= (driver is not None)
        if driver is not None:
            press = (driver.by, driver.press)
            assert driver.mode == gate.mode
            assert press not in ended
            assert now - last[press] <= LEASE
