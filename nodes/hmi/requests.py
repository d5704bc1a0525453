"""What viewers ask for other than to move and to stop: carried out, or refused and why."""

import asyncio
import traceback
from collections.abc import Callable
from concurrent.futures import Executor
from time import monotonic
from typing import Any

from nodes.hmi.driving import Driving
from nodes.hmi.engineering import ActError, act
from nodes.hmi.engineering import fault as inject
from nodes.hmi.halting import Halting
from nodes.hmi.places import PlacesError, SavedPlaces
from nodes.hmi.protocol.incoming import (
    Act,
    Forget,
    Go,
    InjectFault,
    Partition,
    Release,
    Request,
    Save,
    SetGoal,
    SetLimit,
    SetMode,
    Task,
)
from nodes.hmi.protocol.outgoing import Done, Places
from nodes.hmi.protocol.values import Pose
from nodes.hmi.record import Record
from nodes.hmi.robot_link import RobotLink
from nodes.hmi.seen import pose_of
from nodes.hmi.viewers import Viewer
from runtime.config.deployment import Deployment
from runtime.errors import RunError
from runtime.processes.node import Context
from runtime.wire.bus import BusError

_MOST = 4  # requests of one viewer that are carried out at the same time


class Refused(Exception):
    """A request that is not carried out: a key of the words, and its parameters."""

    def __init__(self, key: str, **params: str | float | int) -> None:
        super().__init__(key)
        self.key, self.params = key, params


class Requests:
    """Carries out what viewers ask for.

    Args:
        context: What the process of the node has.
        link: To the robot.
        driving: Who drives, and what is seen.
        halting: Which halts are under way.
        places: The saved places.
        record: Of what happened.
        post: Sends a message to a viewer, or to all.
        executor: For what takes a while.
    """

    def __init__(
        self,
        context: Context,
        link: RobotLink,
        driving: Driving,
        halting: Halting,
        places: SavedPlaces,
        record: Record,
        post: Callable[[int | None, Any], None],
        executor: Executor,
    ) -> None:
        self._context = context
        self._deployment: Deployment = context.deployment
        self._link, self._driving = link, driving
        self._halting, self._places, self._record = halting, places, record
        self._post, self._executor = post, executor
        self._running: dict[int, int] = {}

    async def carry_out(self, viewer: Viewer, request: Request) -> None:
        """Carry out a request, and answer it."""
        number = viewer.number
        if self._running.get(number, 0) >= _MOST:
            self._post(number, Done(request.id, False, "refused.flood"))
            return
        self._running[number] = self._running.get(number, 0) + 1
        try:
            await self._do(viewer, request)
        except Refused as refused:
            self._post(number, Done(request.id, False, refused.key, refused.params))
        except (RunError, BusError, ActError) as error:
            self._post(number, Done(request.id, False, "refused.robot", {"why": str(error)}))
        except PlacesError as error:
            self._post(number, Done(request.id, False, "refused.places", {"why": str(error)}))
        except Exception as error:  # a defect of ours, or of the system's: the page goes on
            why = f"{type(error).__name__}: {error}"
            self._context.refusals.count("page", "failed", traceback.format_exc())
            self._post(number, Done(request.id, False, "refused.robot", {"why": why[:200]}))
        else:
            self._post(number, Done(request.id, True))
        finally:
            self._running[number] -= 1
            if not self._running[number]:
                del self._running[number]

    async def _do(self, viewer: Viewer, request: Request) -> None:
        match request:
            case SetMode(mode=mode):
                self._must_drive(viewer)
                await self._choose(mode)
            case SetLimit(limit=limit):
                self._must_drive(viewer)
                operator = self._link.look(monotonic()).operator
                if operator is None:
                    raise Refused("refused.plant")
                await self._in_thread(self._link.choose, operator.mode, limit)
            case Release():
                self._halting.withdraw()
                await self._in_thread(self._link.end_halt)
            case SetGoal(position=position, orientation=orientation):
                self._set_goal(viewer, Pose(position, orientation))
            case Go(place=place):
                if place not in self._places.poses:
                    raise Refused("refused.place", place=place)
                self._set_goal(viewer, self._places.poses[place])
            case Save(place=place):
                if self._driving.seen.hand is None:
                    raise Refused("refused.plant")
                self._places.save(place, pose_of(self._driving.seen.hand))
                self._changed_places("place.saved", place)
            case Forget(place=place):
                self._places.forget(place)
                self._changed_places("place.forgotten", place)
            case Task(task=task):
                self._must_drive(viewer)
                if task not in tasks_of(self._deployment):
                    raise Refused("refused.task", task=task)
                await self._choose("automatic")
                self._note("task.started", task=task)
            case Act(what=what, role=role):
                self._must_be_engineer(viewer)
                run, roles = self._context.run, self._deployment.roles
                await self._in_thread(act, run, roles, what, role)
                self._note("act.done", what=what, role=role)
            case InjectFault(fault=fault):
                self._must_be_engineer(viewer)
                await self._in_thread(inject, self._context.run, fault)
                self._note("fault.done", fault=fault)
            case Partition(host=host, seconds=seconds):
                self._must_be_engineer(viewer)
                await self._in_thread(self._link.cut_off, host, seconds)
                self._note("partition.done", host=host, s=seconds)

    async def _choose(self, mode: str) -> None:
        """Choose a mode; what moves ends before, and agents that are let loose rest at first."""
        driving = self._driving
        driving.rest("mode", monotonic())
        if mode == "automatic" and not tasks_of(self._deployment) and driving.seen.hand is not None:
            self._link.stand(pose_of(driving.seen.hand), driving.seen.t)
        await self._in_thread(self._link.choose, mode)

    def _set_goal(self, viewer: Viewer, pose: Pose) -> None:
        """Make a pose the goal for as long as the robot is in automatic mode."""
        self._must_drive(viewer)
        if tasks_of(self._deployment):
            raise Refused("refused.source")
        operator = self._driving.seen.operator
        if operator is None:
            raise Refused("refused.plant")
        if operator.halted:
            raise Refused("refused.halted", by=operator.halted_by)
        if operator.mode != "automatic":
            raise Refused("refused.mode", mode=operator.mode)
        self._driving.marker = pose
        self._link.stand(pose, self._driving.seen.t)
        self._note("goal.set")

    def _must_drive(self, viewer: Viewer) -> None:
        if not self._driving.drivers.take(viewer.number, monotonic()):
            raise Refused("refused.driver", driver=self._driving.drivers.driver or 0)

    def _must_be_engineer(self, viewer: Viewer) -> None:
        if viewer.role != "engineer":
            raise Refused("refused.role")

    def _changed_places(self, key: str, place: str) -> None:
        self._post(None, Places(self._places.poses))
        self._note(key, place=place)

    def _note(self, key: str, **params: str | float | int) -> None:
        self._record.note(self._driving.seen.t, key, **params)

    async def _in_thread(self, what: Callable[..., None], *more: object) -> None:
        await asyncio.get_running_loop().run_in_executor(self._executor, what, *more)


def tasks_of(deployment: Deployment) -> tuple[str, ...]:
    """Return the names of what the robot does by itself in automatic mode: of its goal's class."""
    name = "" if deployment.goal is None else deployment.goal.class_.name
    return (name.rpartition(":")[2],) if name else ()
