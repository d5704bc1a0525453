import random

import pytest

from runtime.config.chaos import ChaosEvent
from runtime.rehearsal.switch import Links

HOSTS = ("robot", "arm", "base")
PAIRS = [(one, other) for one in HOSTS for other in HOSTS if one != other]


def links(*impairments: ChaosEvent) -> Links:
    links = Links(random.Random(1))
    links.impairments = list(impairments)
    return links


def test_an_unimpaired_network_delivers_at_once() -> None:
    assert [links().due(*pair, now=3.0) for pair in PAIRS] == [3.0] * 6


@pytest.mark.parametrize("cut", [{"arm"}, {"robot", "base"}])
def test_hosts_of_a_partition_reach_each_other_and_no_others(cut: set[str]) -> None:
    network = links(ChaosEvent(at=0.0, partition=tuple(cut)))
    for sender, receiver in PAIRS:
        reached = network.due(sender, receiver, 1.0) is not None
        assert reached == ("arm" not in (sender, receiver))


def test_an_impairment_can_be_ended() -> None:
    network = links(ChaosEvent(at=0.0, partition=("arm",)))
    network.impairments.clear()
    assert network.due("arm", "robot", 1.0) == 1.0


def test_delays_affect_all_traffic_of_their_hosts_and_add_up() -> None:
    network = links(
        ChaosEvent(at=0.0, delay=("arm",), time=0.02),
        ChaosEvent(at=0.0, delay=("arm", "base"), time=0.1),
    )
    assert network.due("arm", "robot", 1.0) == pytest.approx(1.12)
    assert network.due("arm", "base", 1.0) == pytest.approx(1.12)
    assert network.due("robot", "base", 1.0) == pytest.approx(1.1)


def test_jitter_varies_the_delay_and_keeps_the_order() -> None:
    network = links(ChaosEvent(at=0.0, delay=("arm",), time=0.02, jitter=0.005))
    sent = [index * 1e-3 for index in range(1000)]
    came = [network.due("arm", "robot", now) or 0.0 for now in sent]
    assert came == sorted(came)
    late = [after - before for before, after in zip(sent, came, strict=True)]
    assert 0.015 <= min(late) < 0.017
    assert 0.024 < max(late) <= 0.025


def test_loss_drops_a_share_of_the_packets() -> None:
    network = links(ChaosEvent(at=0.0, loss=("arm",), share=0.02))
    lost = sum(network.due("robot", "arm", 0.0) is None for _ in range(10_000))
    assert 150 < lost < 250
    assert all(network.due("robot", "base", 0.0) is not None for _ in range(1000))
