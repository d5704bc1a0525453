import argparse
from pathlib import Path

import pytest

from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment
from runtime.config.options import add_deployment_options, load_from
from runtime.config.tree import ConfigError

FILE = str(Path(__file__).parents[3] / "deploy" / "arph.yaml")


def loaded(*options: str) -> Deployment:
    parser = argparse.ArgumentParser()
    add_deployment_options(parser)
    return load_from(parser.parse_args([FILE, *options]))


def refused(*options: str) -> str:
    with pytest.raises(ConfigError) as caught:
        loaded(*options)
    return str(caught.value)


def test_a_file_alone_is_read_as_it_is() -> None:
    assert loaded().robot == "arph"


def test_the_usual_values_have_options_of_their_own() -> None:
    options = ["--robot", "b", "--speed", "20", "--duration"]
    deployment = loaded(*options, "12 s", "--seed", "7")
    assert (deployment.robot, deployment.speed) == ("b", 20.0)
    assert (deployment.duration, deployment.seed) == (12.0, 7)


def test_any_value_can_be_set() -> None:
    deployment = loaded(
        "--set", "agents.joint/1.memory=0.3 s", "--set", "goal.velocity=[0, 0, 1 cm/s]"
    )
    assert deployment.agent("joint/1").parameters["memory"] == 0.3
    assert deployment.goal is not None
    assert deployment.goal.parameters["velocity"] == (0.0, 0.0, 0.01)


def test_the_later_of_two_options_wins() -> None:
    assert loaded("--seed", "2", "--set", "seed=3").seed == 3
    assert loaded("--set", "seed=3", "--seed", "2").seed == 2


def test_chaos_is_added_to_that_of_the_file() -> None:
    deployment = loaded(
        *("--kill", "joint/2@8", "--revive", "joint/2@9 s"),
        *("--stop", "goal@5s", "--fault", "joint/1:locked=60deg@500 ms"),
        *("--hang", "joint/2@8:2s", "--partition", "local@9:4 s"),
    )
    assert deployment.chaos == (
        ChaosEvent(at=8.0, kill="joint/2"),
        ChaosEvent(at=9.0, revive="joint/2"),
        ChaosEvent(at=5.0, stop="goal"),
        ChaosEvent(at=0.5, fault="joint/1:locked=60deg"),
        ChaosEvent(at=8.0, hang="joint/2", for_=2.0),
        ChaosEvent(at=9.0, partition=("local",), for_=4.0),
    )


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--set", "period=-1", "period: -1 must be positive, such as 60 ms"),
        ("--set", "perid=1", "unknown key 'perid'; did you mean 'period'? valid are robot,"),
        ("--set", "agents.joint/9.memory=1", "agents has no joint/9; it has joint/1, joint/2,"),
        (
            "--set",
            "agents.0.memroy=1",
            "agents.joint/1: unknown key 'memroy'; did you mean 'memory'?",
        ),
        ("--set", "period", "write PATH=VALUE, such as --set period=20ms"),
        ("--set", "seed=[1", "is not YAML: did not find expected"),
        ("--robot", "a b", "robot: 'a b' is not a robot's name, such as arph"),
        ("--speed", "-2", "speed: -2 must be positive, such as 1"),
        ("--duration", "", "duration: '' is not a time; write one such as 60 ms or 0.06 s"),
        ("--seed", "x", "seed: 'x' is not a whole number, such as 1"),
        ("--kill", "joint/2", "the time is missing, such as --kill joint/2@8"),
        ("--kill", "joint/9@8", "chaos.0.kill: no process has the role 'joint/9'; did you mean"),
        ("--kill", "joint/2@soon", "chaos.0.at: 'soon' is not a time"),
        ("--hang", "joint/2@8:soon", "chaos.0.for: 'soon' is not a time"),
        ("--partition", "local,base@8", "chaos.0.partition.1: there is no host 'base'"),
        ("--stop", "goal@99", "chaos.0.at: 99 must be before the end of the run, 24 s"),
        ("--fault", "joint/1:lame@5", "chaos.0.fault: joint has no fault 'lame'"),
    ],
)
def test_an_error_names_the_option(option: str, value: str, says: str) -> None:
    assert refused(option, value).startswith(f"{option} {value}: {says}")
