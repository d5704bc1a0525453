"""A stop is asked for until it is confirmed, and only as often as somebody pressed it."""

import asyncio
from concurrent.futures import ThreadPoolExecutor

from msgspec import Struct

from nodes.hmi.halting import Halting
from nodes.hmi.protocol.outgoing import Halted
from tests.runtime.conftest import SOON


class Asked:
    """A robot that confirms the first stops late, and what its viewers are told."""

    def __init__(self, late: int) -> None:
        self.left, self.asked = late, 0
        self.said: list[tuple[int, int, bool]] = []

    def ask(self, _: str, timeout: float) -> bool:
        self.asked += 1
        self.left -= 1
        return self.left < 0

    def post(self, viewer: int, message: Struct) -> None:
        assert isinstance(message, Halted)
        self.said.append((viewer, message.id, message.confirmed))


def halted(robot: Asked, *presses: tuple[int, int]) -> None:
    """Stop it as viewers press, each once what was pressed before is confirmed."""

    async def press() -> None:
        with ThreadPoolExecutor(1) as thread:
            halting = Halting(robot.ask, robot.post, thread, 10.0, lambda *_: None)
            for viewer, id_ in presses:
                halting.halt(viewer, id_)
                while (viewer, id_, True) not in robot.said:
                    await asyncio.sleep(0.001)
            await asyncio.sleep(0.0)

    with ThreadPoolExecutor(1) as thread:  # in that of the test Playwright may have a loop
        thread.submit(lambda: asyncio.run(asyncio.wait_for(press(), SOON))).result()


def test_the_robot_is_asked_until_it_confirms() -> None:
    robot = Asked(late=2)
    halted(robot, (1, 7))
    assert robot.asked == 3
    assert robot.said == [(1, 7, True)]


def test_what_was_sent_again_before_the_answer_came_is_no_new_stop() -> None:
    robot = Asked(late=0)
    halted(robot, (1, 7), (1, 7), (2, 7), (1, 8))
    assert robot.asked == 3
    assert robot.said == [(1, 7, True), (2, 7, True), (1, 8, True)]
