import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.wire import keys
from runtime.wire.messages import Diag, GoalMessage, HandPose, JointCommand

ROLES = ["plant", "goal", "platform", "joint/1", "joint/12", "launcher"]


@pytest.mark.parametrize("role", ROLES)
def test_a_role_comes_back_from_its_file_name(role: str) -> None:
    assert keys.is_role(role)
    assert "/" not in keys.file_name(role)
    assert keys.role_of_file(keys.file_name(role)) == role


@pytest.mark.parametrize("name", ["", "Joint/1", "joint/", "joint/1/2", "joint/x", "../etc", "a b"])
def test_what_is_no_role_is_told(name: str) -> None:
    assert not keys.is_role(name)


@given(st.sampled_from(ROLES), st.integers(0, 2**63 - 1))
def test_a_token_says_who_is_alive(role: str, incarnation: int) -> None:
    assert keys.who_is_alive(keys.alive(role, incarnation)) == (role, incarnation)


@given(st.text())
def test_any_other_token_says_nothing(key: str) -> None:
    assert keys.who_is_alive(key) is None


def test_each_key_has_its_kind_of_message() -> None:
    assert keys.kind_of(keys.HAND) is HandPose
    assert keys.kind_of(keys.joint_command(3)) is JointCommand
    assert {keys.kind_of(key) for key in keys.GOALS} == {GoalMessage}
    assert keys.kind_of(keys.diag("joint/3")) is Diag
    assert keys.kind_of("arm/joint/x/cmd") is None
    assert keys.kind_of("weather") is None
