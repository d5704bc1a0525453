"""Carrying out chaos: to processes by signals, to the robot by asking the plant, to the network."""

import os
import signal
import subprocess
import time
from collections.abc import Callable
from typing import Protocol

from plant.errors import MsmaError
from runtime.chaos.schedule import Due
from runtime.config.chaos import LAUNCHER, WATCHER, ChaosEvent
from runtime.config.deployment import Deployment
from runtime.config.tree import ConfigError
from runtime.errors import RunError
from runtime.launching.journal import Journal
from runtime.watching.control import Control
from runtime.watching.local import watchers

ANSWER = 0.5
"""How long a request of chaos waits for its answer [s]: other events may be due."""


class Network(Protocol):
    """What joins the hosts of a run, if it can be cut and slowed down."""

    def impair(self, event: ChaosEvent, *, over: bool) -> None:
        """Begin a partition, a delay or a loss for the event's hosts, or end it."""


def check_means(deployment: Deployment, network: Network | None) -> None:
    """Raise `ConfigError` if the deployment's chaos needs a network that cannot be impaired."""
    for index, event in enumerate(deployment.chaos):
        if event.hosts and network is None:
            raise ConfigError(
                f"chaos.{index}.{event.action}: {event.target}: these processes run on a network "
                f"that cannot be broken from here; only a rehearsal of hosts on one machine can"
            )


class FaultInjector:
    """Carries out what is due.

    Args:
        start_successor: Called with plant time [s] before the launcher kills itself.
        network: Carries out events between hosts.
    """

    def __init__(
        self,
        deployment: Deployment,
        control: Control,
        journal: Journal,
        start_successor: Callable[[float], None] | None = None,
        network: Network | None = None,
    ) -> None:
        self._deployment, self._control, self._network = deployment, control, network
        self._journal, self._start_successor = journal, start_successor
        self.hung: dict[ChaosEvent, list[int]] = {}  # what hangs because of an event

    def carry_out(self, due: Due) -> None:
        """Let an event begin, or end, and say what came of it."""
        event, target = due.event, due.event.target
        match event.action:
            case "kill":
                self._kill(target, due.at)
            case "hang" if due.over:
                self._resume(event)
            case "hang":
                self._hang(event)
            case "stop":
                agrees = self._control.stop(target)
                what = "is asked to stop" if agrees else "does not answer to a stop"
                self._journal.happened(f"{target} {what}")
            case "revive":
                self._revive(target)
            case "fault":
                self._break(target)
            case _:
                self._to_network(event, due.over)

    def _kill(self, role: str, at: float) -> None:
        if role == LAUNCHER and self._start_successor is not None:
            self._start_successor(at)
        if pids := self._pids(role, "killed"):
            self._note("kill", role, pids=pids)
            self._send(role, pids, signal.SIGKILL)

    def _hang(self, event: ChaosEvent) -> None:
        role = event.target
        if not (pids := self._pids(role, "hung")):
            return
        lasting = "" if event.for_ is None else f" for {event.for_:g} s"
        self._journal.happened(f"{role} hangs{lasting}")
        self._note("hang", role, pids=pids)
        if role == LAUNCHER and event.for_ is not None:  # which cannot resume itself
            waking = f"sleep {event.for_ / self._deployment.speed:f}; kill -CONT {os.getpid()}"
            subprocess.Popen(["sh", "-c", waking], start_new_session=True)
        else:
            self.hung[event] = pids
        self._send(role, pids, signal.SIGSTOP)

    def _resume(self, event: ChaosEvent) -> None:
        if pids := self.hung.pop(event, []):
            self._note("wake", event.target, pids=pids)
            self._send(event.target, pids, signal.SIGCONT)
            self._journal.happened(f"{event.target} goes on")

    def _revive(self, role: str) -> None:
        called = round(time.time(), 6)  # starting it is a part of what its return takes
        try:
            pid = self._control.processes.revive(role, self._deployment.host_of(role))
        except RunError as error:
            self._journal.happened(f"{role} cannot be started again: {error}")
        else:
            self._note("revive", role, wall=called, pids=[pid])
            self._journal.show(f"{role} is started again")

    def _break(self, fault: str) -> None:
        try:
            self._control.fault(fault)
        except MsmaError as error:
            self._journal.happened(f"no fault {fault}: {error}")
        else:
            self._note("fault", fault)
            self._journal.show(f"fault {fault}")

    def _to_network(self, event: ChaosEvent, over: bool) -> None:
        if self._network is None:
            return  # it was refused before anything was started
        self._network.impair(event, over=over)
        self._note(event.action, event.target, over=over)
        what = {"partition": "cut off", "delay": "slowed down", "loss": "made to lose packets"}
        verb = f"{'are' if len(event.hosts) > 1 else 'is'}{' no longer' if over else ''}"
        self._journal.happened(f"{event.target} {verb} {what[event.action]}")

    def _pids(self, role: str, to_be: str) -> list[int]:
        """Return the process of a role, of copies the one that is obeyed; say so if it is gone."""
        if role == LAUNCHER:
            pids = [] if self._start_successor is None else [os.getpid()]
        elif role == WATCHER:
            pids = [watcher.pid for watcher in watchers(self._deployment.robot)]
        else:
            pids = self._control.processes.obeyed(role)
        if not pids:
            self._journal.happened(f"{role} is not there to be {to_be}")
        return pids

    def _send(self, role: str, pids: list[int], number: signal.Signals) -> None:
        """Send a signal; the launcher and the watchers are not among the processes of `Control`."""
        if role == LAUNCHER:
            os.kill(os.getpid(), number)
        elif role == WATCHER:
            for watcher in watchers(self._deployment.robot):
                watcher.send(number)
        else:
            self._control.processes.send(role, pids, number)

    def _note(self, action: str, target: str, **more: object) -> None:
        """Log what is about to be done, at once: this process may be the next one to end."""
        self._journal.write("chaos", action=action, target=target, **more)
        self._journal.log.flush()
