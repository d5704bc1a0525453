"""Kill the process of a role on this host with SIGKILL."""

import argparse
import socket
from signal import SIGKILL

from runtime.errors import RunError
from runtime.spawning.local import LocalProcesses
from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.watching.local import diags


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_target_options(parser, role="role, such as joint/2; its process must run on this host")


def run(args: argparse.Namespace) -> int:
    """Kill the process; of several copies the one whose commands are accepted."""
    target = target_of(args)
    with visit(target) as bus:
        hosts = {diag.host for diag in diags(bus, args.role)}
        if hosts and socket.gethostname() not in hosts:
            where = ", ".join(sorted(hosts))
            raise RunError(f"{args.role} runs on {where}: use this command there")
        processes = LocalProcesses(target.run_with(args.role))
        pids = processes.obeyed(args.role)
        if not pids:
            raise RunError(f"no process of {args.role} runs here")
        processes.send(args.role, pids, SIGKILL)
    print(f"killed {args.role}, process {pids[0]}")
    return 0
