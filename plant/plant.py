"""A plant: what moves when it is commanded, whether it is simulated or real."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import ClassVar, NamedTuple

from plant.faults import Fault, FaultError
from plant.robot import Robot, Row
from plant.solids import Solid
from plant.world import WorldObject


class Sensor(NamedTuple):
    """A sensor that a plant has beyond those that every plant has.

    Attributes:
        key: The topic on which it is published, such as `platform/ranges`.
        percept: The name by which an agent asks for it, such as `ranges`.
        reading: The type of what it measures: a NamedTuple or a frozen dataclass of floats,
            tuples of floats, ints or strings, with units in its docstring.
    """

    key: str
    percept: str
    reading: type


class Commands(NamedTuple):
    """The speeds that the motors are to have.

    Attributes:
        joints: (..., n) [rad/s], of a prismatic joint [m/s].
        base: (..., 2) forward [m/s] and turning [rad/s], of a holonomic base (..., 3): to the left
            [m/s]; of no effect without a drive.
        gripper: The opening that the fingers are to have [m], and their largest force [N]. The
            drive keeps to it until the next one; None while there is none.
    """

    joints: Row
    base: Row = (0.0, 0.0)
    gripper: tuple[float, float] | None = None


class Readings(NamedTuple):
    """What the sensors measure: plain numbers of one robot, arrays of a batch of robots.

    Attributes:
        t: Plant time [s], which starts near 0 and never goes back.
        q: (..., n) of the encoders [rad or m]; NaN where one is lost.
        qd: (..., n) of the encoders [rad/s or m/s]; NaN likewise.
        position: (..., 3) of the tip in the world [m] by the localiser; None when it is lost.
        rotation: (..., 3, 3), or 9 row by row: the tip's x, y and z directions in the world as
            columns, by the localiser; None when it is lost.
        base: (..., 3) x, y [m] and heading [rad] in the world; None without a drive.
        sensors: By percept, the readings of `Plant.sensors` that there are at this time.
    """

    t: float
    q: Row
    qd: Row
    position: Row | None = None
    rotation: Row | None = None
    base: Row | None = None
    sensors: Mapping[str, object] = MappingProxyType({})


class Truth(NamedTuple):
    """How the robot truly moves, for judging a run; shapes and units as in `Readings`.

    Attributes:
        t: Plant time [s].
        q: Joint positions.
        qd: Joint speeds.
        base: x, y and heading in the world, zeros without a drive.
        base_velocity: (..., 2) or (..., 3), as of `Commands.base`.
        position: Of the tip in the world.
        rotation: Of the tip in the world.
    """

    t: float
    q: Row
    qd: Row
    base: Row
    base_velocity: Row
    position: Row
    rotation: Row


class Contact(NamedTuple):
    """The robot has begun to touch something.

    Attributes:
        t: Plant time [s].
        part: What of the robot, such as `platform`.
        object: Name of what it touches.
        force: The largest of this contact [N]; None if the plant knows no forces.
    """

    t: float
    part: str
    object: str
    force: float | None = None


@dataclass(frozen=True, eq=False)
class Setup:
    """What every plant is made with.

    Attributes:
        robot: What it moves.
        q: (..., n) joint positions to start from [rad or m]; leading dimensions are a batch of
            robots.
        base: (..., 3) x, y [m] and heading [rad] to start from; None for zeros.
        period: Of the control loop [s].
        seed: Of all that is random in it.
        world: What stands around the robot.
    """

    robot: Robot
    q: Row
    base: Row | None = None
    period: float = field(kw_only=True)
    seed: int | Sequence[int] = field(default=0, kw_only=True)
    world: tuple[WorldObject, ...] = field(default=(), kw_only=True)


class Plant(ABC):
    """The robot as its control loop sees it: each period `write`, `step` and `read`, in this order.

    A deployment names a class `module:Class`. Its constructor is `Class(setup, *, options...)`:
    the keyword parameters, with their annotations, are what a deployment file may set. It may
    raise `ValueError` for them, but touches nothing outside itself: files are checked by making
    one, also where the robot is not.
    """

    sensors: ClassVar[tuple[Sensor, ...]] = ()
    """The sensors that it has beyond encoders, localiser and odometry."""

    def __init__(self, setup: Setup) -> None:
        """Be the plant of that robot, not connected to anything yet."""
        self.robot, self.period = setup.robot, setup.period

    def open(self) -> None:  # noqa: B027 - a simulated one has nothing to open
        """Connect to what it drives. Called once, before all that follows."""

    @abstractmethod
    def write(self, commands: Commands) -> None:
        """Take the speeds for the coming period; they are finite and within the robot's limits."""

    @abstractmethod
    def step(self) -> None:
        """Go on by one period; a real robot, which moves by itself, need not do anything.

        Called once a period of real time. It should not block: the next commands wait for it.
        """

    @abstractmethod
    def read(self) -> Readings:
        """Return what the sensors measure now."""

    def close(self) -> None:  # noqa: B027 - nor to close
        """Bring the robot to rest and let go of it. Called once, at the end or after an error.

        A process that is killed does not call it: a real robot needs a watchdog in its drives.
        """

    def truth(self) -> Truth | None:
        """Return how the robot truly is; None, by default, if only sensors can say."""
        return None

    def solids(self) -> Sequence[Solid]:
        """Return the objects of the world where they are; none, by default, if it cannot tell."""
        return ()

    def contacts(self) -> tuple[Contact, ...]:
        """Return the contacts since this was last called; none, by default, if it knows of none."""
        return ()

    def check_fault(self, fault: Fault) -> None:
        """Raise `FaultError` for a fault that it cannot be given: by default, for every one."""
        raise FaultError(f"{fault}: a {type(self).__name__} cannot be given faults")

    def inject(self, fault: Fault) -> None:
        """Let a fault begin now, or end with kind `ok`; raise `FaultError` like `check_fault`."""
        self.check_fault(fault)
