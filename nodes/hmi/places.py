"""Places that a person has saved, such as `mouth`: in a file of the user's for each robot."""

import math
import os
from collections.abc import Mapping
from pathlib import Path

import msgspec

from nodes.hmi.protocol.incoming import Target
from nodes.hmi.protocol.values import Name, Pose
from plant.errors import MsmaError
from runtime.atomic import write_atomically

_MOST = 64


class PlacesError(MsmaError, ValueError):
    """Places that cannot be read, or not be saved: it says why."""


def places_file(robot: str) -> Path:
    """Return the file of a robot's places, in the folder for what programs remember (XDG)."""
    state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(state) / "msma" / "places" / f"{robot}.json"


class SavedPlaces:
    """The places of a robot, by their names.

    A file that cannot be read leaves them empty, and is not written over.

    Attributes:
        error: Why the file cannot be read; empty if it can, or if there is none.
    """

    def __init__(self, file: Path) -> None:
        self._file = file
        self._places: dict[str, Target] = {}
        self.error = ""
        try:
            self._places = _read(file)
        except PlacesError as error:
            self.error = str(error)

    @property
    def poses(self) -> Mapping[str, Pose]:
        """All places."""
        return {
            name: Pose(one.position, one.orientation) for name, one in sorted(self._places.items())
        }

    def save(self, name: str, pose: Pose) -> None:
        """Save a place in place of what had that name; `PlacesError` if it cannot be kept."""
        if name not in self._places and len(self._places) >= _MOST:
            raise PlacesError(f"there are {_MOST} places already: forget one first")
        self._write(self._places | {name: Target(pose.position, pose.orientation)})

    def forget(self, name: str) -> None:
        """Forget a place; `PlacesError` if there is no such place."""
        if name not in self._places:
            raise PlacesError(f"there is no place {name!r}")
        self._write({other: one for other, one in self._places.items() if other != name})

    def _write(self, places: dict[str, Target]) -> None:
        """Write all, and change what is known only if that succeeds."""
        if self.error:
            raise PlacesError(f"{self.error}; repair or remove it first")
        text = msgspec.json.format(msgspec.json.encode(places))
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(self._file, lambda new: new.write_bytes(text))
        except OSError as error:
            raise PlacesError(f"{self._file}: {error.strerror}") from None
        self._places = places


def _read(file: Path) -> dict[str, Target]:
    try:
        places = msgspec.json.decode(file.read_bytes(), type=dict[Name, Target])
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise PlacesError(f"{file}: {error.strerror}") from None
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise PlacesError(f"{file}: {error}") from None
    for name, one in places.items():
        if one.orientation is not None and abs(math.hypot(*one.orientation) - 1.0) > 1e-3:
            raise PlacesError(f"{file}: {name}: orientation is no unit quaternion x, y, z, w")
    return places
