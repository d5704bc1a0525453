"""The command-line options of the verbs that take a deployment file."""

import argparse
import json
from functools import partial

from runtime.config.deployment import Deployment, load
from runtime.config.overrides import Override
from runtime.config.tree import ConfigError

_OPTIONS = {
    "--set": ("PATH=VALUE", "set any value, such as agents.joint/1.gain=0.4"),
    "--robot": ("NAME", "name of the robot on the network"),
    "--speed": ("FACTOR", "plant time per real time, such as 4"),
    "--duration": ("TIME", "end the run after this plant time, such as 10s"),
    "--seed": ("NUMBER", "seed of everything random"),
    "--scheduling": ("POLICY", "priority of the processes: normal, realtime or auto"),
    "--kill": ("ROLE@TIME", "kill a process, such as joint/2@8"),
    "--hang": ("ROLE@TIME:TIME", "suspend a process for a while, such as joint/2@8:2s"),
    "--stop": ("ROLE@TIME", "ask a process to stop"),
    "--revive": ("ROLE@TIME", "start a process again"),
    "--fault": ("FAULT@TIME", "inject a fault into the robot, such as joint/1:locked@5"),
    "--partition": ("HOST@TIME:TIME", "cut hosts off from the others, such as arm@8:4s"),
}


def _override(option: str, text: str) -> Override:
    source, key = f"{option} {text}", option.removeprefix("--")
    if key == "set":
        path, equals, value = text.partition("=")
        if not equals:
            raise ConfigError(f"{source}: write PATH=VALUE, such as --set period=20ms")
        return Override(source, path.strip(), value)
    if "@" not in _OPTIONS[option][0]:
        return Override(source, key, json.dumps(text))
    target, at_sign, at = text.rpartition("@")
    if not at_sign:
        raise ConfigError(f"{source}: the time is missing, such as {source}@8")
    at, colon, lasting = at.partition(":")
    event = {"at": at, key: target.split(",") if key == "partition" else target}
    return Override(source, "chaos.+", json.dumps(event | ({"for": lasting} if colon else {})))


def add_deployment_options(parser: argparse.ArgumentParser) -> None:
    """Add the deployment file, and the options that override its values."""
    parser.add_argument("file", metavar="FILE", help="deployment file, such as deploy/arph.yaml")
    group = parser.add_argument_group("overrides", "All times are plant time.")
    for option, (metavar, text) in _OPTIONS.items():
        # Made later, in `load_from`: argparse would hide the message of a ConfigError.
        note = partial(partial, _override, option)
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
