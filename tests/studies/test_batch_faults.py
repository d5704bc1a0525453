import numpy as np
import pytest

from plant.faults import Fault
from studies.batch_faults import BatchFaults
from studies.lockstep import Event, run
from studies.mobile import ARPH, POSTURE, msma, plant, task

FAULTS = [
    "joint/1:locked=-130deg",
    "joint/2:locked=20deg",
    "joint/3:weak=0.5",
    "joint/1:locked",
    "platform:weak=0.5",
]


@pytest.mark.parametrize("period", [0.06, 0.02])
def test_each_robot_of_a_batch_moves_as_the_plant_with_that_fault(period: float) -> None:
    each = BatchFaults.none(ARPH, len(FAULTS))
    each.since[:] = 3.0
    each.locked[0, 0], each.locked[1, 1] = np.radians([-130.0, 20.0])
    each.strength[2, 2], each.strength[3, 0], each.platform[4] = 0.5, 0.0, 0.5
    many = run(plant(each=each, period=period), msma(period), task().piece, 6.0)
    for row, text in enumerate(FAULTS):
        one = run(
            plant(period=period),
            msma(period),
            task().piece,
            6.0,
            events=[Event(3.0, Fault.parse(text, ARPH))],
        )
        np.testing.assert_allclose(many.q[:, row], one.q, atol=1e-9)
        np.testing.assert_allclose(many.base[:, row], one.base, atol=1e-9)


def test_a_batch_without_faults_is_the_plain_plant() -> None:
    each = BatchFaults.none(ARPH, 2)
    many = run(plant(np.stack([POSTURE, POSTURE]), each=each), msma(), task().piece, 2.0)
    one = run(plant(), msma(), task().piece, 2.0)
    np.testing.assert_allclose(many.hand[:, 1], one.hand, atol=1e-12)
