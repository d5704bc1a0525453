"""Faults in words."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant.belt import Belt
from plant.errors import MsmaError
from plant.faults import Fault, FaultError, fault_texts
from plant.urdf import load

ARPH, PLANAR5 = load("arph"), load("planar5")


@pytest.mark.parametrize(
    ("text", "target", "kind", "value"),
    [
        ("joint/1:locked", "joint/1", "locked", None),
        ("joint/1:locked=60deg", "joint/1", "locked", math.radians(60)),
        ("joint/2:locked=-0.5 rad", "joint/2", "locked", -0.5),
        ("joint/6:limp", "joint/6", "limp", None),
        ("joint/3:weak", "joint/3", "weak", 0.5),
        ("joint/3:weak=25 %", "joint/3", "weak", 0.25),
        ("joint/3:runaway", "joint/3", "runaway", 0.2),
        ("joint/3:ok", "joint/3", "ok", None),
        ("encoder/1:stuck", "encoder/1", "stuck", None),
        ("encoder/1:lost", "encoder/1", "lost", None),
        ("encoder/1:biased=-2deg", "encoder/1", "biased", math.radians(-2)),
        ("encoder/1:noisy", "encoder/1", "noisy", math.radians(0.5)),
        ("localiser:lost", "localiser", "lost", None),
        ("localiser:noisy=2mm", "localiser", "noisy", 0.002),
        ("localiser:late=0.2", "localiser", "late", 0.2),
        ("platform:locked", "platform", "locked", None),
        (" platform : weak = 0.3 ", "platform", "weak", 0.3),
    ],
)
def test_a_fault_is_read_with_its_value_in_si(
    text: str, target: str, kind: str, value: float | None
) -> None:
    fault = Fault.parse(text, ARPH)
    assert (fault.target, fault.kind, fault.value) == (target, kind, value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("joint/1", "'joint/1' is no fault; write TARGET:KIND, such as joint/2:locked"),
        ("", "'' is no fault; write TARGET:KIND"),
        ("wheel:locked", "there is no part 'wheel' to be at fault; valid are joint/N, encoder/N"),
        ("joint:locked", "there is no part 'joint'"),
        ("joint/x:locked", "there is no part 'joint/x'"),
        ("platform/1:locked", "there is no part 'platform/1'"),
        ("joint/0:locked", "robot 'arph' has no joint/0; valid are joint/1 to joint/6"),
        ("encoder/7:lost", "robot 'arph' has no encoder/7; valid are encoder/1 to encoder/6"),
        (
            "joint/1:broken",
            "joint has no fault 'broken'; valid are locked, limp, weak, runaway, ok",
        ),
        ("localiser:stuck", "localiser has no fault 'stuck'; valid are lost, noisy, late, ok"),
        ("joint/1:limp=3", "joint/1:limp takes no value"),
        ("joint/1:locked=60ms", "60ms is a time; an angle is wanted, such as 60 deg"),
        ("joint/1:locked=", "'' is not an angle"),
        ("localiser:late=5mm", "5mm is a length; a time is wanted"),
        ("joint/1:weak=1.5", "joint/1:weak=1.5 is out of range; valid are 0 to 1"),
        ("joint/1:weak=-0.1", "out of range"),
        ("localiser:late=-1ms", "localiser:late=-1ms is out of range; valid are 0ms to 10000ms"),
        ("joint/1:locked=60", "valid are -360deg to 360deg"),
        ("joint/2:locked=170deg", "joint 'shoulder' cannot get there; valid are -60deg to 150deg"),
    ],
)
def test_what_is_no_fault_is_refused_with_what_is(text: str, message: str) -> None:
    with pytest.raises(FaultError) as error:
        Fault.parse(text, ARPH)
    assert message in str(error.value)


def test_a_robot_without_a_platform_cannot_have_its_faults() -> None:
    with pytest.raises(FaultError, match="robot 'planar5' has no platform"):
        Fault.parse("platform:locked", PLANAR5)


def test_a_value_that_is_not_finite_is_refused() -> None:
    with pytest.raises(FaultError, match="out of range"):
        Fault("joint/1", "weak", math.nan)


angles = st.floats(-1.0, 1.0)
faults = st.one_of(
    st.builds(Fault, st.just("joint/2"), st.just("locked"), st.none() | angles),
    st.builds(Fault, st.just("joint/4"), st.sampled_from(["weak", "runaway"]), st.floats(0, 1)),
    st.builds(Fault, st.just("encoder/6"), st.just("biased"), angles),
    st.builds(Fault, st.just("localiser"), st.just("noisy"), st.floats(0, 1)),
    st.builds(Fault, st.just("localiser"), st.just("late"), st.floats(0, 10)),
    st.builds(Fault, st.just("platform"), st.sampled_from(["locked", "weak", "ok"])),
)


@given(faults)
def test_a_fault_reads_back_from_its_own_text_as_exactly_the_same(fault: Fault) -> None:
    assert Fault.parse(str(fault), ARPH) == fault


def test_a_fault_is_written_in_the_units_people_use() -> None:
    assert str(Fault.parse("joint/1:locked=1.0471975511965976", ARPH)) == "joint/1:locked=60deg"
    assert str(Fault.parse("localiser:late=0.1", ARPH)) == "localiser:late=100ms"


def test_a_fault_error_is_an_msma_error_and_a_value_error() -> None:
    assert issubclass(FaultError, MsmaError)
    assert issubclass(FaultError, ValueError)


def test_values_of_a_sliding_joint_are_lengths() -> None:
    robot = load("telescope")
    locked = Fault.parse("joint/1:locked=30 cm", robot)
    assert (locked.value, str(locked)) == (0.3, "joint/1:locked=300mm")
    assert str(Fault.parse("encoder/2:biased", robot)) == "encoder/2:biased=5mm"
    assert str(Fault.parse("encoder/3:biased", robot)) == "encoder/3:biased=5deg"
    with pytest.raises(FaultError, match="60 deg is an angle; a length is wanted"):
        Fault.parse("joint/1:locked=60 deg", robot)
    with pytest.raises(FaultError, match="cannot get there; valid are 0mm to 900mm"):
        Fault.parse("joint/1:locked=2 m", robot)


def test_the_faults_that_a_robot_can_have_are_those_of_its_parts() -> None:
    belted = replace(ARPH, belt=Belt(sensors=2))
    for robot in (ARPH, PLANAR5, belted):
        for text in fault_texts(robot):
            Fault.parse(text, robot).check(robot)
    of_arph, of_planar5, of_belted = map(set, map(fault_texts, (ARPH, PLANAR5, belted)))
    assert {"joint/6:limp", "platform:locked", "gripper:limp", "hand:push_x"} <= of_arph
    assert not {"platform:locked", "gripper:limp", "joint/6:limp"} & of_planar5
    lost = {text for text in of_belted - of_arph if text.endswith(":lost")}
    assert lost == {"ranges/1:lost", "ranges/2:lost"}
