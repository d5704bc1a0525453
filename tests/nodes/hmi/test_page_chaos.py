"""In automatic mode nobody needs the page: it is killed, revived and hung, as any other process."""

import json

from tests.nodes.hmi.conftest import WebRobot
from tests.runtime.conftest import ROOT

SHORT = ("--duration", "12 s", "--set", "start.rest_after=null")
PLACE = ("--set", "goal.rpy=null")  # with faults the hand need not be turned as it was
PAGE = ("--kill", "hmi@2.5", "--revive", "hmi@4", "--hang", "hmi@8:1.5 s")


def test_the_task_is_done_with_the_page_killed_revived_and_hung(web_robot: WebRobot) -> None:
    file = str(ROOT / "deploy" / "arph-web.yaml")
    more = ("--robot", web_robot.name, *SHORT, *PLACE, *PAGE, "--runs", "1", "--seed", "3")
    campaign = web_robot.msma("chaos", file, *more)
    assert campaign.returncode == 0, campaign.stdout + campaign.stderr
    said = json.loads(next(web_robot.folder.glob("runs/*/chaos.json")).read_text())
    (run,) = said["runs"]
    assert sum("hmi@" in fault for fault in run["chaos"]) >= 3
    assert web_robot.processes() == {}
