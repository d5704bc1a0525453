"""Check whether this machine and a robot's hosts, certificates and ports are ready.

Without --robot or --file, check only the machine. Exit codes: 0 if nothing is bad, otherwise 1.
"""

import argparse
from pathlib import Path

from runtime.config.deployment import load
from runtime.doctor.certificates import check_certificates
from runtime.doctor.machine import Grade, check_machine
from runtime.doctor.network import check_hosts, check_robot
from runtime.watching.discovery import add_target_options, target_of
from runtime.watching.table import columns
from runtime.wire.mesh import FIRST_COPY
from runtime.wire.topics import PLANT


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    deployment = None if args.file is None else load(args.file, only_role=PLANT)
    findings = list(check_machine(Path.cwd() / "runs" if deployment is None else deployment.runs))
    can_join = args.robot is not None
    if deployment is not None:
        certificates = list(check_certificates(deployment))
        findings += [*certificates, *check_hosts(deployment)]
        can_join = all(one.grade is not Grade.BAD for one in certificates)
    if can_join:
        roles = FIRST_COPY if deployment is None else len(deployment.roles)
        findings += check_robot(target_of(args), roles)
    print("\n".join(columns([(one.grade.value, one.what, one.detail) for one in findings])))
    return 1 if any(one.grade is Grade.BAD for one in findings) else 0
