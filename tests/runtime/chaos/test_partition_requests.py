"""What may be asked of the launcher of a rehearsal, and what is due when by histories of time."""

from dataclasses import replace

import pytest

from runtime.chaos.partition_requests import PartitionRequests, longest, read
from runtime.chaos.schedule import Due
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment, load
from runtime.config.tree import ConfigError
from tests.runtime.conftest import ROOT

HOSTS = ("robot", "arm", "base")
MOST = 8.0  # [s]


@pytest.fixture(scope="module")
def deployment() -> Deployment:
    return load(ROOT / "deploy" / "arph-hosts.yaml")


@pytest.mark.parametrize(
    ("text", "hosts", "seconds"),
    [
        ("arm 2", ("arm",), 2.0),
        ("arm,base 0.1", ("arm", "base"), 0.1),
        ("arm,arm 8.0", ("arm",), 8.0),
    ],
)
def test_a_request_names_hosts_and_a_time(
    text: str, hosts: tuple[str, ...], seconds: float
) -> None:
    assert read(text, HOSTS, MOST) == (hosts, seconds)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("leg 2", "there is no host 'leg'.* valid are robot, arm, base"),
        (" 2", "there is no host ''.*valid are robot, arm, base"),
        ("", "there is no host ''"),
        ("arm", "lasts 0.1 to 8 s, not for no time"),
        *((f"arm {time}", "lasts 0.1 to 8 s, not") for time in ("-2", "0", "60.1", "1e9", "soon")),
        *((f"arm {time}", "lasts 0.1 to 8 s, not") for time in ("nan", "inf", "-inf", "2 3")),
    ],
)
def test_another_one_is_refused_by_what_is_wrong_and_what_would_be_valid(
    text: str, why: str
) -> None:
    with pytest.raises(ConfigError, match=why):
        read(text, HOSTS, MOST)


def test_the_longest_leaves_time_to_come_back_and_is_bounded(deployment: Deployment) -> None:
    assert longest(replace(deployment, patience=10.0)) == 8.0
    assert longest(replace(deployment, patience=1e6)) == 60.0


def test_without_a_rehearsal_it_is_refused(deployment: Deployment) -> None:
    with pytest.raises(ConfigError, match=r"arph is no rehearsal; .* msma launch FILE --rehearse"):
        PartitionRequests(deployment, possible=False).take(b"arm 2")


def test_each_begins_after_its_answer_and_ends_in_time_although_plant_time_stands_still(
    deployment: Deployment,
) -> None:
    requests = PartitionRequests(deployment, possible=True)
    assert requests.due(4.0, now=100.0) == []
    assert requests.take(b"arm,base 2") == b"arm, base cut off for 2 s"
    event = ChaosEvent(at=4.0, partition=("arm", "base"), for_=2.0)
    due = [requests.due(4.0, now) for now in (100.0, 100.1, 100.3, 102.1, 102.3, 200.0)]
    assert due == [[], [], [Due(4.0, event)], [], [Due(4.0, event, over=True)], []]


def test_several_at_the_same_time_each_have_their_end(deployment: Deployment) -> None:
    requests = PartitionRequests(deployment, possible=True)
    requests.take(b"arm 3")
    requests.take(b"arm 1")
    ends = [
        [one.event.for_ for one in requests.due(4.0, now) if one.over]
        for now in (100.0, 101.1, 101.3, 103.3)
    ]
    assert ends == [[], [], [1.0], [3.0]]


def test_a_refused_request_is_never_due(deployment: Deployment) -> None:
    requests = PartitionRequests(deployment, possible=True)
    with pytest.raises(ConfigError):
        requests.take(b"arm \xff")
    assert requests.due(4.0, now=100.0) == requests.due(4.0, now=1000.0) == []
