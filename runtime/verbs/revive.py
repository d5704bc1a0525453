"""Start the process of a role again, in the run that goes on; it outlives this command."""

import argparse
import time
from pathlib import Path

from runtime.config.deployment import load
from runtime.launching.failures import RunError
from runtime.launching.finding import add_target_options, target_of, visit
from runtime.launching.local import diags, run_of
from runtime.launching.nursery import Nursery
from runtime.launching.starting import Task
from runtime.wire.bus import Bus

_PATIENCE = 10.0  # [s] for it to be seen alive


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add which robot and which role."""
    parser.add_argument("role", metavar="ROLE", help="such as joint/2")
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Start it and wait until it is there; 1 if it does not come."""
    began = time.monotonic()
    with Nursery() as nursery, visit(target_of(args)) as bus:
        told = diags(bus)
        if any(diag.role == args.role for diag in told):
            raise RunError(f"{args.role} is alive; `msma agent --copy` starts another beside it")
        task = _task(Path(run_of(told).run), args.role)
        child = nursery.start(task)
        while not _is_alive(bus, args.role, child.pid):
            if child.poll() is not None:
                raise RunError(f"{args.role} did not start: {task.said}")
            if time.monotonic() - began > _PATIENCE:
                raise RunError(f"{args.role}, process {child.pid}, is not seen alive")
            time.sleep(0.02)
    print(f"{args.role} runs again, process {child.pid}, {time.monotonic() - began:.2f} s")
    return 0


def _task(run: Path, role: str) -> Task:
    """Return what to start, or raise `MsmaError` if this run has no such role."""
    task = Task(role, run)
    if not task.file.is_file():
        raise RunError(f"there is no {task.file}: start it with `msma agent FILE {role}`")
    load(task.file, only_role=role)
    return task


def _is_alive(bus: Bus, role: str, pid: int) -> bool:
    return any(diag.pid == pid for diag in diags(bus, role))
