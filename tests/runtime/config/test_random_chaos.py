"""What chaos by lot draws, and that a run's folder says it in full."""

from pathlib import Path

import pytest

from runtime.config.chaos import ChaosEvent, RandomChaos, fault
from runtime.config.deployment import Deployment, load
from runtime.config.overrides import Override
from runtime.config.tree import ConfigError

FILE = Path(__file__).parents[3] / "deploy" / "arph.yaml"


def loaded(text: str, *more: tuple[str, str]) -> Deployment:
    overrides = [Override("test", path, value) for path, value in more]
    return load(FILE, [Override("test", "random_chaos", text), *overrides])


@pytest.mark.parametrize(
    ("role", "manner", "events"),
    [
        ("goal", "kill", (ChaosEvent(at=3.0, kill="goal"),)),
        ("goal", "hang", (ChaosEvent(at=3.0, hang="goal", for_=1.5),)),
        ("goal", "restart", (ChaosEvent(at=3.0, kill="goal"), ChaosEvent(at=4.5, revive="goal"))),
        ("launcher", "restart", (ChaosEvent(at=3.0, kill="launcher"),)),
    ],
)
def test_a_fault_is_one_event_or_two(
    role: str, manner: str, events: tuple[ChaosEvent, ...]
) -> None:
    assert fault(role, manner, 3.0, 1.5) == events


def test_what_was_drawn_is_written_as_events_so_that_the_run_can_be_repeated(
    tmp_path: Path,
) -> None:
    deployment = loaded("{rate: 0.5 Hz}")
    assert deployment.chaos
    assert deployment.random_chaos is None
    (tmp_path / "again.yaml").write_text(deployment.dump())
    assert load(tmp_path / "again.yaml") == deployment


def test_the_seed_decides_what_is_drawn() -> None:
    first = loaded("{rate: 0.5 Hz}")
    assert loaded("{rate: 0.5 Hz}") == first
    assert loaded("{rate: 0.5 Hz, seed: 1}").chaos == first.chaos  # the deployment's by default
    assert loaded("{rate: 0.5 Hz, seed: 2}").chaos != first.chaos
    assert loaded("{rate: 0.5 Hz}", ("seed", "2")).chaos != first.chaos


def test_it_comes_at_its_rate_and_within_the_run() -> None:
    events = RandomChaos(rate=2.0, seed=1, manners=("hang",)).draw(("goal",), 500.0)
    assert 900 < len(events) < 1100
    assert all(0 < event.at < 500 and 0.5 <= (event.for_ or 0) <= 3.0 for event in events)


def test_anybody_but_the_plant_is_hit_unless_others_are_named() -> None:
    deployment = loaded("{rate: 20 Hz, manners: [kill]}")
    assert {event.role for event in deployment.chaos} == set(deployment.chaos_targets)
    assert "plant" not in deployment.chaos_targets
    named = loaded("{rate: 5 Hz, roles: [joint/2, goal]}")
    assert {event.role for event in named.chaos} == {"joint/2", "goal"}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{}", "random_chaos: the key 'rate' is missing, such as rate: 0.1 Hz"),
        ("{rate: 0}", "random_chaos.rate: 0 must be positive, such as 0.1 Hz"),
        ("{rate: 1, roles: [plant]}", "random_chaos.roles.0: no process has the role 'plant'"),
        ("{rate: 1, manners: [slap]}", "'slap'"),
        ("{rate: 1, manners: []}", "the list is empty; valid are kill, hang, restart"),
        ("{rate: 1, lasting: [3 s, 1 s]}", "the minimum is larger than the maximum"),
    ],
)
def test_what_cannot_be_drawn_from_is_refused(text: str, says: str) -> None:
    with pytest.raises(ConfigError) as caught:
        loaded(text)
    assert says in str(caught.value)


def test_without_an_end_nothing_can_be_drawn() -> None:
    with pytest.raises(ConfigError, match="needs a `duration`"):
        loaded("{rate: 1 Hz}", ("duration", "null"))
