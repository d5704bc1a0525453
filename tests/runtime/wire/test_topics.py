import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.wire import topics
from runtime.wire.messages import Diag, EndEffectorPose, GoalMessage, JointCommand

ROLES = ["plant", "goal", "platform", "joint/1", "joint/12", "launcher"]


@pytest.mark.parametrize("role", ROLES)
def test_a_role_comes_back_from_its_file_name(role: str) -> None:
    assert topics.is_role(role)
    assert "/" not in topics.file_name(role)
    assert topics.role_of_file(topics.file_name(role)) == role


@pytest.mark.parametrize("name", ["", "Joint/1", "joint/", "joint/1/2", "joint/x", "../etc", "a b"])
def test_what_is_no_role_is_told(name: str) -> None:
    assert not topics.is_role(name)


@given(st.sampled_from(ROLES), st.integers(0, 2**63 - 1))
def test_a_token_says_who_is_alive(role: str, incarnation: int) -> None:
    assert topics.who_is_alive(topics.alive(role, incarnation)) == (role, incarnation)


@given(st.text())
def test_any_other_token_says_nothing(key: str) -> None:
    assert topics.who_is_alive(key) is None


def test_each_key_has_its_kind_of_message() -> None:
    assert topics.kind_of(topics.HAND) is EndEffectorPose
    assert topics.kind_of(topics.joint_command(3)) is JointCommand
    assert {topics.kind_of(key) for key in topics.GOALS} == {GoalMessage}
    assert topics.kind_of(topics.diag("joint/3")) is Diag
    assert topics.kind_of("arm/joint/x/cmd") is None
    assert topics.kind_of("weather") is None
