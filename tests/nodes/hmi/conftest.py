"""A robot with a page, of real processes, that waits at rest."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest

from nodes.hmi.address import Address, find_address
from runtime.results.run_log import RunLog, read_run_log
from tests.nodes.hmi.client import Browser, Message
from tests.runtime.conftest import DEADLINE, ROOT, RUN_DEADLINE, Robot, wait_for

WEB = """
import sys
from argparse import ArgumentParser
from nodes.hmi import web_verb as web
from runtime.errors import exit_code

parser = ArgumentParser()
web.add_arguments(parser)
sys.exit(exit_code(lambda: web.run(parser.parse_args())))
"""
"""`msma web`, found even if the tree is not installed."""


class WebRobot(Robot):
    """A robot with a page."""

    def begin(self, *options: str) -> Address:
        """Start it, and wait for its page."""
        self.environment["XDG_STATE_HOME"] = str(self.folder / "state")
        file, rest = ROOT / "deploy" / "arph-web.yaml", ("--set", "start.mode=rest")
        self.start("launch", str(file), "--robot", self.name, *rest, *options)
        wait_for(lambda: list(self.folder.glob("runs/*/page.json")), "the page")
        return self.address

    def start_web(self, *arguments: str) -> Address:
        """Start it by `msma web`, and wait for its page."""
        command = [sys.executable, "-c", WEB, *arguments, "--robot", self.name]
        pipe = subprocess.PIPE
        self._started.append(
            subprocess.Popen(
                command, cwd=self.folder, env=self.environment, stdout=pipe, stderr=pipe, text=True
            )
        )
        wait_for(lambda: list(self.folder.glob("runs/*/page.json")), "the page")
        return self.address

    def msma_web(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Call `msma web` and wait for its end."""
        return subprocess.run(
            [sys.executable, "-c", WEB, *arguments],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=RUN_DEADLINE,
        )

    @property
    def address(self) -> Address:
        address = find_address(self.run_folder)
        assert address is not None
        return address

    def motion(self, since: float) -> RunLog:
        """Return what the plant has logged by now, which is at least up to plant time `since`."""
        self.until(since)
        return read_run_log(self.run_folder)

    def moved(self, since: float, until: float) -> float:
        """Return how far the hand went between two plant times at most [m]."""
        log = self.motion(until)
        hand = log.hand[(log.t >= since - 1e-6) & (log.t <= until + 1e-6)]
        return float(np.linalg.norm(hand - hand[0], axis=1).max())


@pytest.fixture
def web_robot(tmp_path: Path) -> Iterator[WebRobot]:
    with ExitStack() as stack:
        yield WebRobot(tmp_path, stack)


@contextmanager
def driven(browser: Browser, *speeds: float, metres: float, **fields: object) -> Iterator[Message]:
    """Hold a button until the hand has gone that far, and then on until the end of the block.

    It is pressed again if its press ends before, as on a machine that is too busy to hold it.
    """
    start, deadline = np.array(browser.hand), time.monotonic() + DEADLINE
    while time.monotonic() < deadline:
        with browser.holding(*speeds, **fields) as press:

            def ended(press: int = press) -> bool:
                found = [one for one in list(browser.all) if one["type"] == "ended"]
                return any(one["press"] == press for one in found)

            def far() -> bool:
                return bool(np.linalg.norm(np.array(browser.hand) - start) >= metres)

            browser.wait_for(lambda: ended() or far(), "the hand to move")
            if not ended():
                yield browser.wait_state(lambda one: one["hand"], "the hand")
                return
    raise AssertionError(f"no press moved the hand: {browser.all[-5:]}")
