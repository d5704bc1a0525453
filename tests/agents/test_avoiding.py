"""What a platform makes of its range sensors: what it remembers, when it stops, what it says."""

from dataclasses import replace

import numpy as np
import pytest

from agents.agent import Body, Percepts
from agents.braking import Brakes
from agents.echoes import FORGETS, Sonar
from agents.outline import Outline
from agents.platform import PlatformAgent
from plant.belt import Belt, Ranges
from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.plant import Commands, Setup
from plant.urdf import load
from plant.world import ObjectPath, WorldObject
from tests.agents.conftest import START

REACH, UNIT = 1.0, 3.0
BELT = Belt(sensors=8, noise=0.0)
FREE = np.full(8, BELT.most)
OUTLINE = Outline(load("arph"))


@pytest.fixture
def seeing(arph):
    return replace(arph, belt=BELT)


def looks(*sights, sonar=None):
    """What is remembered after looks at (t, base, ranges)."""
    sonar, echoes = sonar or Sonar(BELT, OUTLINE, REACH, UNIT), None
    for t, base, ranges in sights:
        echoes = sonar.look(echoes, t, np.array(base, dtype=float), ranges)
    return echoes


def echo(sensor, at):
    ranges = FREE.copy()
    ranges[sensor] = at
    return ranges


def brakes(robot):
    sonar = Sonar(BELT, OUTLINE, REACH, UNIT)
    return Brakes(robot.drive, OUTLINE, sonar, REACH, 0.2)


def wall(x=1.5):
    return WorldObject(name="wall", box=(0.1, 20.0, 1.0), position=(x, 0.0, 0.5), fixed=True)


def test_the_outline_is_the_convex_hull_of_the_platform(arph):
    outline = Outline(arph)
    points = np.array([0.45 + 0j, 0.55 + 0.1j, -0.3 + 0j, 0.3j, 0.2 + 0j])
    np.testing.assert_allclose(outline.gap(points)[:4], [0.0, 0.1, 0.05, 0.0], atol=1e-9)
    assert outline.gap(points)[4] < -0.2


def test_an_echo_lies_along_the_axis_of_its_sensor():
    echoes = looks((0.0, (1.0, 2.0, np.pi / 2), echo(0, 0.5)))
    first = BELT.layout[0]
    at = 1 + 2j + 1j * (first.x + 1j * first.y + 0.5 * np.exp(1j * first.bearing))
    np.testing.assert_allclose(echoes.points, [at], atol=1e-12)


def test_an_echo_is_forgotten_once_its_sensor_sees_through_the_place():
    still = (0.0, 0.0, 0.0)
    seen = (0.0, still, echo(3, 1.0))
    assert looks(seen, (0.1, still, echo(3, 1.001))).points.size == 1
    free = [(0.1 * n, still, FREE) for n in range(1, 4)]
    assert looks(seen, *free[:2]).points.size == 1, "a lost echo is none"
    assert looks(seen, *free).points.size == 0


def test_what_is_beside_the_platform_is_forgotten_as_it_goes_on():
    sonar = Sonar(BELT, OUTLINE, REACH, UNIT)
    on = [(0.1 * n, (0.1 * n, 0.0, 0.0), FREE) for n in range(2, 40)]
    seen = (0.0, (0.0, 0.0, 0.0), echo(0, 0.3))
    going = [len(looks(seen, *on[:n], sonar=sonar).points) for n in range(1, 38, 4)]
    assert going[0] >= 1
    assert going[-1] == 0
    assert FORGETS * REACH < 3.9


def test_only_the_nearest_echoes_are_kept(monkeypatch):
    monkeypatch.setattr("agents.echoes.POINTS", 3)
    echoes = looks((0.0, (0.0, 0.0, 0.0), np.linspace(0.5, 2.0, 8)))
    assert sorted(np.abs(echoes.points)) == list(np.abs(echoes.points))
    assert len(echoes.points) == 3


def waits(*sights, sonar=None):
    echoes = looks(*sights, sonar=sonar)
    return echoes.t < echoes.waits


@pytest.mark.parametrize("sensor", [0, 3, 7])
def test_what_comes_where_it_was_free_moves_by_itself(sensor):
    still = (0.0, 0.0, 0.0)
    stands = [(0.1 * n, still, echo(sensor, 1.0)) for n in range(5)]
    assert not waits(*stands)
    came = [(0.1 * n, still, FREE) for n in range(3)]
    comes = [(0.1 * n, still, echo(sensor, 1.0)) for n in range(3, 5)]
    assert not waits(*came, comes[0]), "once is no proof"
    assert waits(*came, *comes)
    later = [(0.1 * n, still, echo(sensor, 1.0)) for n in range(3, 60)]
    assert not waits(*came, *later), "it stands now"


def test_what_was_measured_before_it_turned_does_not_come_as_it_turns():
    sights = [(0.06 * n, (0.0, 0.0, turn), echo(3, 1.0)) for n, turn in enumerate((0.0, 0.55, 0.6))]
    assert waits(*sights), "measured anew at each look"
    slow = Sonar(replace(BELT, rate=10.0), OUTLINE, REACH, UNIT)
    assert not waits(*sights, sonar=slow), "measured once, and published again"


def test_before_a_lost_sensor_there_may_be_something_until_others_have_looked():
    lost = FREE.copy()
    lost[3] = np.nan

    def unseen(*headings):
        sights = [(0.1 * n, (1.0, 2.0, h), lost) for n, h in enumerate(headings)]
        return looks(*sights).unseen - (1 + 2j)

    assert np.abs(unseen(0.0)).min() > OUTLINE.radius, "it can turn to look"
    assert unseen(*np.linspace(0.0, 0.2, 5)).size > 0
    there = np.linspace(0.0, 0.7, 12)
    assert unseen(*there, *there[::-1]).size == 0


@pytest.mark.parametrize("speed", [0.05, 0.15, 0.3])
def test_it_may_go_as_fast_as_it_can_stop_before_what_it_sees(seeing, speed):
    base, wanted = np.zeros(3), np.array([speed, 0.0])
    needs = speed**2 / 2 / seeing.drive.max_linear_acceleration + 0.2 * speed
    front = 0.445 - 0.45  # of the two middle sensors, before the outline
    for gap, free in ((needs + 0.1, True), (needs, False), (0.02, False)):
        echoes = looks((0.0, base, echo(3, gap - front)))
        shares = brakes(seeing).limit(echoes, base, wanted).shares
        assert (shares[0] == 1.0) == free
        assert shares[0] >= 0.0


def test_it_may_turn_away_from_what_has_come_too_close(seeing):
    base = np.zeros(3)
    echoes = looks((0.0, base, echo(0, 0.06)))  # to the left of its front
    turns = [brakes(seeing).limit(echoes, base, np.array([0.3, w])).shares for w in (0.8, -0.8)]
    assert turns[0] @ [0.3, 0.8] < turns[1] @ [0.3, 0.8]


@pytest.mark.parametrize("far", [0.8, 2.5])
def test_it_waits_for_somebody_who_moves_however_far_away(seeing, far):
    base = np.zeros(3)
    free = [(0.1 * n, base, FREE) for n in range(3)]
    came = looks(*free, *[(0.1 * n, base, echo(3, far)) for n in (3, 4)])
    np.testing.assert_array_equal(
        brakes(seeing).limit(came, base, np.array([0.3, 0.8])).shares, 0.0
    )
    stood = looks((0.0, base, echo(3, far)))
    assert brakes(seeing).limit(stood, base, np.array([0.3, 0.0])).shares[0] == 1.0


def test_where_it_does_not_see_it_is_slower_and_blind_it_stands(seeing):
    base, wanted = np.zeros(3), np.array([0.3, 0.0])

    def share(*lost):
        ranges = FREE.copy()
        ranges[list(lost)] = np.nan
        return brakes(seeing).limit(looks((0.0, base, ranges)), base, wanted).shares[0]

    assert share() == 1.0
    assert 0.0 < share(3) < 1.0
    assert 0.0 < share(3, 4) < 1.0
    assert share(*range(8)) == 0.0
    assert brakes(seeing).limit(looks((0.0, base, None)), base, wanted).shares[0] == 0.0


def driven(robot, world, goal, seconds, faults=()):
    """The plant and its agent after so long: the arm does not move."""
    agent = PlatformAgent(Body(robot, None, 0.06, 1))
    setup = Setup(robot, START, np.zeros(3), period=0.06, world=world)
    plant = KinematicPlant(setup, [Fault.parse(fault, robot) for fault in faults])
    contacts = []
    for _ in range(round(seconds / 0.06)):
        plant.write(Commands(np.zeros(6), agent.decide(Percepts.of(plant.read(), goal))))
        plant.step()
        contacts += plant.contacts()
    return agent, plant.truth(), contacts


def test_before_a_wall_it_stops_and_says_why(seeing, percepts):
    goal = percepts((4.0, 0.0, 0.0)).goal
    agent, truth, contacts = driven(seeing, (wall(),), goal, 40.0)
    assert not contacts
    assert truth.base[0] < 1.45 - 0.45
    assert agent.trouble.startswith("stands: something 0.")
    assert agent.trouble.endswith("sees no way round")


@pytest.mark.parametrize("faults", [(), ("ranges/4:lost",)])
def test_it_goes_round_a_thing_that_is_in_its_way(seeing, percepts, faults):
    box = WorldObject(name="box", box=(0.5, 0.6, 1.0), position=(1.5, 0.0, 0.5), fixed=True)
    goal = percepts((3.0, 0.0, 0.0)).goal
    agent, truth, contacts = driven(seeing, (box,), goal, 30.0, faults)
    assert not contacts
    assert np.hypot(*(np.array(truth.position) - goal.position)[:2]) < 0.05
    assert agent.trouble == ""


def test_somebody_who_walks_across_is_not_touched(seeing, percepts):
    way = ObjectPath(points=((1.4, 2.5, 0.85), (1.4, -3.0, 0.85)), speed=1.0, start=0.5)
    person = WorldObject(name="person", cylinder=(0.25, 1.7), path=way)
    goal = percepts((3.0, 0.0, 0.0)).goal
    _, truth, contacts = driven(seeing, (person,), goal, 25.0)
    assert not contacts
    assert np.hypot(*(np.array(truth.position) - goal.position)[:2]) < 0.05


def test_a_belt_of_which_nothing_is_heard_lets_it_stand(seeing, percepts):
    agent = PlatformAgent(Body(seeing, None, 0.06, 0))
    assert "ranges" in agent.sees
    for tick in range(150):
        said = agent.decide(percepts((3.0, 0.0, 0.0), t=0.06 * tick))
    np.testing.assert_array_equal(said, 0.0)
    assert agent.trouble == "stands: hears nothing of its range sensors"


def test_with_a_belt_that_sees_nothing_it_plans_as_without(arph, seeing, percepts):
    with_belt, without = (PlatformAgent(Body(one, None, 0.06, 0)) for one in (seeing, arph))
    assert "ranges" not in without.sees
    for tick in range(30):
        seen = percepts((0.4, 0.7, 0.0), t=0.06 * tick)
        sensors = {"ranges": Ranges(tuple(FREE))}
        np.testing.assert_array_equal(
            with_belt.decide(seen._replace(sensors=sensors)), without.decide(seen)
        )
