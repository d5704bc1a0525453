"""A robot on several hosts which are all this machine, by addresses of its own: no root needed."""

import json
import re
import socket
from collections.abc import Callable
from typing import Any

import pytest
from msgspec.structs import replace

from runtime import VERSION
from runtime.config.deployment import load
from runtime.config.overrides import Override
from runtime.doctor.machine import Grade
from runtime.doctor.network import check_hosts, check_robot, check_running
from runtime.results.summary import MISSED
from runtime.watching.discovery import Target
from runtime.wire.mesh import Mesh
from runtime.wire.messages import Diag, Spread
from tests.ports import reserve_any
from tests.runtime.conftest import ROOT, RUN_DEADLINE, Robot, came_in_time, wait_for

FILE = "arph-hosts.yaml"
DEPLOYMENT = ROOT / "deploy" / FILE


def test_each_host_s_share_is_started_by_hand_and_tools_on_one_find_all(robot: Robot) -> None:
    options = ("--duration", "21s", "--set", "patience=20s")
    shares = [
        robot.launch("--host", name, *options, "--set", f"runs={robot.folder / name}", file=FILE)
        for name in ("base", "arm", "robot")
    ]

    def status() -> Any:
        said = robot.tool("status", "--json").stdout
        return json.loads(said) if said.count('"alive": true') == 9 else None

    seen = wait_for(status, "all nine processes in the status")
    assert seen["robot"] == robot.name
    said = [share.communicate(timeout=RUN_DEADLINE)[0] for share in shares]
    late = () if came_in_time(max((robot.folder / "robot").iterdir())) else (MISSED,)
    *others, plants = [share.returncode for share in shares]
    assert others == [0, 0], said
    assert plants in (0, *late), said
    for name, words in zip(("base", "arm"), said, strict=False):
        ran = re.search(rf"the share of {name} ran to (\S+) s", words)  # what it last heard of
        assert ran is not None, words
        assert 15.0 < float(ran[1]) <= 21.0
    assert "goal reached" in said[2] or plants == MISSED
    assert robot.processes() == {}
    assert {file.stem for file in (robot.folder / "arm").glob("*/*.jsonl")} == {
        "launcher",
        *(f"joint-{number}" for number in range(1, 7)),
    }


def test_a_share_of_no_host_is_refused(robot: Robot) -> None:
    code, said = robot.run("--host", "amr", file=FILE)
    assert (code, said) == (
        2,
        "msma: no process runs on a host 'amr'; did you mean 'arm'? valid are robot, base, arm\n",
    )


def test_processes_of_another_machine_are_not_started_here(robot: Robot) -> None:
    code, said = robot.run("--set", "hosts.arm=192.0.2.7", file=FILE)  # of nobody's, by RFC 5737
    assert code == 1
    assert "this one does not have address 192.0.2.7" in said
    assert "--host" in said
    assert robot.processes() == {}


NOW = 1.7e9


def diag(role: str = "plant", host: str = "here", offset: float = 0.0, **changes: Any) -> Diag:
    none = Spread(0.0, 0.0, 0.0)
    said = Diag(
        *(1.0, role, host, 42, "runs", 16.7, none, {}, {}, "auto", "/run", "a.yaml"),
        version=VERSION,
        clock=round(1e6 * (NOW + offset)),
    )
    return replace(said, **changes)


@pytest.mark.parametrize(
    ("diags", "what", "grade", "parts"),
    [
        ([diag("joint/1")], "plant", Grade.BAD, ("is missing", "msma revive plant")),
        ([diag(), diag(host="there")], "arph", Grade.BAD, ("2 plants", "on here", "on there")),
        ([diag(), diag("goal", version="9.9")], "versions", Grade.BAD, ("here has 9.9", VERSION)),
        (
            [diag(), diag("goal", "far", offset=-3.0)],
            "clocks",
            Grade.WARN,
            ("far", "3.00 s behind"),
        ),
    ],
)
def test_doctor_reports_problems_of_a_running_robot(
    diags: list[Diag], what: str, grade: Grade, parts: tuple[str, ...]
) -> None:
    every = check_running("arph", diags, NOW, 0.001)
    found = [one for one in every if (one.what, one.grade) == (what, grade)]
    assert len(found) == 1
    assert all(part in found[0].detail for part in parts)


def test_doctor_reports_no_problem_of_a_healthy_robot() -> None:
    diags = [diag(), diag("joint/1", "there", offset=0.3)]
    taking_long = 0.4
    assert [one.what for one in check_running("arph", diags, NOW, taking_long)] == ["arph"]


@pytest.mark.parametrize(
    ("address", "part"),
    [("192.0.2.7", "cannot be reached"), ("no-such-host.invalid", "is an unknown host name")],
)
def test_doctor_reports_which_host_cannot_be_reached(address: str, part: str) -> None:
    deployment = load(DEPLOYMENT, [Override("--set", "hosts.arm", address)])
    bad = {one.what: one.detail for one in check_hosts(deployment) if one.grade is Grade.BAD}
    assert part in bad["host arm"]


def test_doctor_finds_another_robot_of_the_same_name(make_robot: Callable[[], Robot]) -> None:
    robot = make_robot()
    robot.launch("--duration", "21s")
    robot.until(0.1)
    mesh = load(DEPLOYMENT).mesh._replace(base=65000)
    found = [one for one in check_robot(Target(robot.name, mesh), 9) if one.what == robot.name]
    assert found[0].grade is Grade.BAD
    assert "another robot of this name runs on this machine" in found[0].detail


def has_ipv6() -> bool:
    try:
        with socket.create_server(("::1", 0), family=socket.AF_INET6):
            return True
    except OSError:
        return False


@pytest.mark.skipif(not has_ipv6(), reason="this machine has no IPv6")
def test_doctor_finds_the_taken_ports_of_an_ipv6_address() -> None:
    base, reservation = reserve_any()
    target = Target("nobody", Mesh(base, ("::1",), ("::1",)))
    with reservation:
        with socket.create_server(("::1", base), family=socket.AF_INET6):
            (taken,) = (one for one in check_robot(target, 1) if one.what == "ports")
        (free,) = (one for one in check_robot(target, 1) if one.what == "ports")
    assert taken.grade is Grade.BAD
    assert taken.detail.startswith(f"{base} of {base} to ")
    assert free.grade is Grade.OK
