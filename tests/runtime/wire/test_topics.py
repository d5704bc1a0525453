import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.wire import topics
from runtime.wire.messages import (
    Diag,
    EndEffectorPose,
    GoalMessage,
    JointCommand,
    Message,
    PlatformPose,
)

ROLES = ["plant", "goal", "platform", "joint/1", "joint/12", "launcher"]


@pytest.mark.parametrize("role", ROLES)
def test_a_role_comes_back_from_its_file_name(role: str) -> None:
    assert "/" not in topics.file_name(role)
    assert topics.role_of_file(topics.file_name(role)) == role


@pytest.mark.parametrize("name", ["", "Joint/1", "joint/", "joint/1/2", "joint/x", "../etc", "a b"])
def test_what_is_no_role_is_told(name: str) -> None:
    assert topics.who_is_alive(f"alive/{name}/1f") is None


@given(st.sampled_from(ROLES), st.integers(0, 2**63 - 1))
def test_a_token_says_who_is_alive(role: str, incarnation: int) -> None:
    assert topics.who_is_alive(topics.alive(role, incarnation)) == (role, incarnation)


@given(st.text())
def test_any_other_token_says_nothing(key: str) -> None:
    assert topics.who_is_alive(key) is None


def test_each_key_has_its_message() -> None:
    def message(key: str) -> type[Message] | None:
        topic = topics.STANDARD.topic_of(key)
        return topic and topic.message

    assert message(topics.HAND) is EndEffectorPose
    assert message(topics.joint_command(3)) is JointCommand
    assert message(topics.GOAL) is message(topics.KNOWN_GOAL) is GoalMessage
    assert message(topics.diag("joint/3")) is Diag
    assert message("arm/joint/x/cmd") is None
    assert message("weather") is None


@pytest.mark.parametrize(
    ("role", "keys"),
    [
        (
            "plant",
            {
                *("arm/ee_pose", "arm/joint_states", "platform/pose", "platform/ranges"),
                *("goal/known", "gripper/state", "operator/known", "world", "diag/plant"),
            },
        ),
        ("hmi", {"operator/jog", "diag/hmi"}),
        ("joint/2", {"arm/joint/2/cmd", "diag/joint/2"}),
        ("joint", {"diag/joint"}),
        ("platform", {"platform/cmd", "diag/platform"}),
        ("gripper", {"gripper/cmd", "diag/gripper"}),
        ("goal", {"goal", "diag/goal"}),
        ("camera", {"diag/camera"}),
    ],
)
def test_each_role_publishes_on_its_own_keys(role: str, keys: set[str]) -> None:
    assert set(topics.STANDARD.keys_of(role)) == keys


OWN = topics.Topic("arm/force", PlatformPose, "plant", "force")


def test_a_topic_of_one_s_own_is_in_the_contract() -> None:
    contract = topics.Contract([OWN])
    assert contract.topic_of("arm/force") is OWN
    assert contract.percepts["force"] == (OWN,)
    assert "arm/force" in contract.keys_of("plant")
    assert topics.STANDARD.topic_of("arm/force") is None


@pytest.mark.parametrize(
    ("key", "percept", "why"),
    [
        ("arm/ee_pose", "force", "has that key already"),
        ("arm/joint/3/cmd", None, "has that key already"),
        ("ctl/plant/stop", None, "has that key already"),
        ("arm/*", None, "lower-case words"),
        ("Arm", None, "lower-case words"),
        ("arm/force", "hand", "there is a percept 'hand' already"),
    ],
)
def test_a_topic_that_does_not_fit_is_refused(key: str, percept: str | None, why: str) -> None:
    with pytest.raises(topics.ContractError, match=why):
        topics.Contract([OWN._replace(key=key, percept=percept)])
