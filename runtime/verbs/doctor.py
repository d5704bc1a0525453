"""Check whether this machine and a robot's place on it are fit to run, and say what to do."""

import argparse
from pathlib import Path

from runtime.config.deployment import load
from runtime.doctor.keys import keys
from runtime.doctor.machine import Grade, machine
from runtime.doctor.network import hosts, place
from runtime.watching.discovery import add_target_options, target_of
from runtime.watching.table import columns
from runtime.wire.mesh import FIRST_COPY
from runtime.wire.topics import PLANT


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add which robot; without one only the machine is looked at."""
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Check; 1 if anything is bad."""
    deployment = None if args.file is None else load(args.file, only_role=PLANT)
    findings = list(machine(Path.cwd() / "runs" if deployment is None else deployment.runs))
    wrong_keys = False
    if deployment is not None:
        of_keys = list(keys(deployment))
        wrong_keys = any(one.grade is Grade.BAD for one in of_keys)
        findings += [*of_keys, *hosts(deployment)]
    if not wrong_keys and (args.robot is not None or deployment is not None):
        roles = FIRST_COPY if deployment is None else len(deployment.roles)
        findings += place(target_of(args), roles)
    print("\n".join(columns([(one.grade.value, one.what, one.detail) for one in findings])))
    return 1 if any(one.grade is Grade.BAD for one in findings) else 0
