"""The page of a rehearsal: reached from this machine, it has hosts cut off, also its own."""

import os
from collections.abc import Callable
from pathlib import Path
from urllib.request import urlopen

import pytest

from nodes.hmi.address import Address
from tests.nodes.hmi.client import Browser, Message
from tests.nodes.hmi.conftest import WebRobot
from tests.runtime.conftest import DEADLINE, wait_for

pytestmark = [
    pytest.mark.skipif(os.geteuid() != 0, reason="namespaces take root: run the tests as root"),
    pytest.mark.skipif(not Path("/dev/net/tun").exists(), reason="needs /dev/net/tun"),
]
CUT = 5.0  # [s], of which a busy machine's launcher may miss some
PAGE = "nodes=[{role: hmi, class: nodes.hmi.page:Page, host: base}]"


@pytest.fixture
def address(web_robot: WebRobot) -> Address:
    """Rehearse a robot on three hosts, with its page on that of the platform."""
    options = ("--rehearse", "--set", PAGE, "--set", "start.mode=automatic")
    web_robot.launch(*options, "--duration", "10min", file="arph-hosts.yaml")
    wait_for(lambda: list(web_robot.folder.glob("runs/*/page.json")), "the page")
    return web_robot.address


def all_run(message: Message) -> bool:
    return all(row["state"] == "runs" for row in message["rows"])


def partitions(robot: WebRobot) -> list[tuple[str, bool]]:
    """Return the hosts of the partitions that have begun, and of those that are over (True)."""
    return [(one["target"], one["over"]) for one in robot.log("launcher", "chaos")]


def obeyed(robot: WebRobot, since: float) -> list[bool]:
    """Return for each tick of the plant since a plant time [s] whether joint 1 was commanded."""
    ticks = [tick for tick in robot.log("plant", "tick") if tick["t"] > since and tick["age"]]
    return [tick["age"][0] is not None for tick in ticks]


def test_an_engineer_cuts_hosts_off_which_come_back(web_robot: WebRobot, address: Address) -> None:
    with urlopen(address.page) as answer:
        assert answer.status == 200
    with Browser(address) as operator:
        refused = operator.ask("partition", host="arm", seconds=CUT)
        assert (refused["ok"], refused["key"]) == (False, "refused.role")
    with Browser(address, address.engineer) as browser:
        hosts = ["robot", "arm", "base"]
        assert browser.last["hello"]["rehearsal"]["hosts"] == hosts
        for host, seconds, why in (
            ("leg", CUT, "valid are robot, arm, base"),
            ("arm", -1, "0.1 to 8 s, not -1.0"),
        ):

            def answered(host: str = host, seconds: float = seconds) -> str:
                refused = browser.ask("partition", host=host, seconds=seconds)
                assert refused["key"] == "refused.robot"
                said: str = refused["params"]["why"]
                return "" if said == "no launcher answers" else said  # they may just connect

            assert why in wait_for(answered, "the launcher's answer")
        browser.wait("processes", all_run, DEADLINE)
        wait_for(lambda: any(obeyed(web_robot, 0.0)), "its agents to be obeyed")
        assert partitions(web_robot) == []

        t = browser.state["t"]
        assert browser.ask("partition", host="arm", seconds=CUT)["ok"]
        browser.wait("happened", happening("partition.done", "host", "arm"))
        browser.wait("happened", happening("process.gone", "role", "joint/1"))
        browser.wait("happened", happening("process.came", "role", "joint/1"))
        wait_for(lambda: was_cut_off(obeyed(web_robot, t)), "its agents to be obeyed again")
        wait_for(lambda: partitions(web_robot) == [("arm", False), ("arm", True)], "the record")

        assert browser.ask("partition", host="base", seconds=CUT)["ok"]  # where the page itself is
        browser.wait_state(lambda state: state["age"] > 0.5, "the page to be cut off")
        browser.wait_state(lambda state: state["age"] < 0.5, "the page to be back")
        both = [("base", False), ("base", True)]
        wait_for(lambda: partitions(web_robot)[2:] == both, "the record")


def was_cut_off(obeyed: list[bool]) -> bool:
    """Tell whether there was no command for a while, and is one now."""
    return obeyed.count(False) > 1 and obeyed[-1]


def happening(key: str, param: str, value: str) -> Callable[[Message], bool]:
    """Return what tells whether a message is of a happening, by one of its parameters."""
    return lambda one: one["what"]["key"] == key and one["what"]["params"].get(param) == value
