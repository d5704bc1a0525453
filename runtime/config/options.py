"""The command-line options of the verbs that take a deployment file."""

import argparse
import json
from collections.abc import Callable
from functools import partial

from runtime.config.deployment import Deployment, load
from runtime.config.overrides import Override
from runtime.config.tree import ConfigError


def _set(option: str, text: str) -> Override:
    path, equals, value = text.partition("=")
    if not equals:
        raise ConfigError(f"{option} {text}: write PATH=VALUE, such as {option} period=20ms")
    return Override(f"{option} {text}", path.strip(), value)


def _value(option: str, text: str) -> Override:
    return Override(f"{option} {text}", option.removeprefix("--"), json.dumps(text))


def _chaos(option: str, text: str) -> Override:
    target, at_sign, at = text.rpartition("@")
    if not at_sign:
        raise ConfigError(f"{option} {text}: the time is missing, such as {option} {text}@8")
    at, colon, lasting = at.partition(":")
    action = option.removeprefix("--")
    event: dict[str, object] = {"at": at, action: target}
    if action == "partition":
        event[action] = target.split(",")
    if colon:
        event["for"] = lasting
    return Override(f"{option} {text}", "chaos.+", json.dumps(event))


_OPTIONS: tuple[tuple[str, str, Callable[[str, str], Override], str], ...] = (
    ("--set", "PATH=VALUE", _set, "set any value, such as agents.joint/1.gain=0.4"),
    ("--robot", "NAME", _value, "name of the robot on the network"),
    ("--speed", "FACTOR", _value, "plant time per real time, such as 4"),
    ("--duration", "TIME", _value, "end the run after this plant time, such as 10s"),
    ("--seed", "NUMBER", _value, "seed of everything random"),
    ("--scheduling", "POLICY", _value, "priority of the processes: normal, realtime or auto"),
    ("--kill", "ROLE@TIME", _chaos, "kill a process, such as joint/2@8"),
    ("--hang", "ROLE@TIME:TIME", _chaos, "suspend a process for a while, such as joint/2@8:2s"),
    ("--stop", "ROLE@TIME", _chaos, "ask a process to stop"),
    ("--revive", "ROLE@TIME", _chaos, "start a process again"),
    ("--fault", "FAULT@TIME", _chaos, "inject a fault into the robot, such as joint/1:locked@5"),
    ("--partition", "HOST@TIME:TIME", _chaos, "cut hosts off from the others, such as arm@8:4s"),
)


def add_deployment_options(parser: argparse.ArgumentParser) -> None:
    """Add the deployment file, and the options that override its values."""
    parser.add_argument("file", metavar="FILE", help="deployment file, such as deploy/arph.yaml")
    group = parser.add_argument_group("overrides", "All times are plant time.")
    for option, metavar, make, text in _OPTIONS:
        # Made later, in `load_from`: argparse would hide the message of a ConfigError.
        note = partial(partial, make, option)
        group.add_argument(
            option, metavar=metavar, help=text, action="append", dest="overrides", type=note
        )


def given(args: argparse.Namespace) -> list[str]:
    """Return the overrides as they were given, without the seed."""
    words = (make.args for make in args.overrides or ())
    return [word for option, text in words if option != "--seed" for word in (option, text)]


def load_from(args: argparse.Namespace, only_role: str | None = None) -> Deployment:
    """Load the deployment of the command line; of two overrides the later one counts."""
    return load(args.file, [make() for make in args.overrides or ()], only_role)
