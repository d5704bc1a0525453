"""The command-line options of every verb that takes a deployment file."""

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
        raise ConfigError(f"{option} {text}: there is no =; write it such as {option} period=20ms")
    return Override(f"{option} {text}", path.strip(), value)


def _value(option: str, text: str) -> Override:
    return Override(f"{option} {text}", option.removeprefix("--"), json.dumps(text))


def _chaos(option: str, text: str) -> Override:
    target, at_sign, at = text.rpartition("@")
    if not at_sign:
        raise ConfigError(f"{option} {text}: at what time? Write it such as {option} {text}@8")
    at, colon, lasting = at.partition(":")
    action = option.removeprefix("--")
    event: dict[str, object] = {"at": at, action: target}
    if action == "partition":
        event[action] = target.split(",")
    if colon:
        event["for"] = lasting
    return Override(f"{option} {text}", "chaos.+", json.dumps(event))


_OPTIONS: tuple[tuple[str, str, Callable[[str, str], Override], str], ...] = (
    ("--set", "PATH=VALUE", _set, "any value, such as agents.joint/1.gain=0.4"),
    ("--robot", "NAME", _value, "the robot's name on the network"),
    ("--speed", "FACTOR", _value, "how many times as fast as real time"),
    ("--duration", "TIME", _value, "how long the run lasts"),
    ("--seed", "NUMBER", _value, "the seed of all that is random"),
    ("--kill", "ROLE@TIME", _chaos, "kill a process at a time, such as joint/2@8"),
    ("--hang", "ROLE@TIME:TIME", _chaos, "stop a process for a time, such as joint/2@8:2s"),
    ("--stop", "ROLE@TIME", _chaos, "ask a process to stop at a time"),
    ("--revive", "ROLE@TIME", _chaos, "start a process again at a time"),
    ("--fault", "FAULT@TIME", _chaos, "break something at a time, such as joint/1:locked@5"),
    ("--partition", "HOST@TIME:TIME", _chaos, "cut hosts off from the rest, such as arm@8:4s"),
)


def add_deployment_options(parser: argparse.ArgumentParser) -> None:
    """Let the command take a deployment file, and options that change values of it."""
    parser.add_argument("file", metavar="FILE", help="a deployment file, such as deploy/arph.yaml")
    group = parser.add_argument_group("in place of what the file says, or beside it")
    for option, metavar, make, text in _OPTIONS:
        # Only noted here: argparse would hide the message of a ConfigError.
        note = partial(partial, make, option)
        group.add_argument(
            option, metavar=metavar, help=text, action="append", dest="overrides", type=note
        )


def given(args: argparse.Namespace) -> list[str]:
    """Return the options as they were given, but for the seed."""
    words = (make.args for make in args.overrides or ())
    return [word for option, text in words if option != "--seed" for word in (option, text)]


def load_from(args: argparse.Namespace, only_role: str | None = None) -> Deployment:
    """Load the deployment that the command line asks for; later options win."""
    return load(args.file, [make() for make in args.overrides or ()], only_role)
