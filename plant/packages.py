"""Robot descriptions inside installed Python packages, such as `example-robot-data`."""

from importlib import metadata
from pathlib import Path, PurePosixPath

from plant.robot import RobotError

_SHOWN = 8  # files that a message lists


def find(package: str, file: str) -> Path:
    """Return the path of a file of an installed package.

    Args:
        package: Name of the distribution, as for `pip install`.
        file: The end of the file's path, such as `panda_description/urdf/panda.urdf`.

    Raises:
        RobotError: The package is not installed, or has no or several files of that name.
    """
    try:
        files = metadata.distribution(package).files or []
    except metadata.PackageNotFoundError:
        raise RobotError(
            f"the package {package!r} is not installed; `pip install {package}` installs it"
        ) from None
    wanted = PurePosixPath(file).parts
    found = [each for each in files if each.name == wanted[-1] and _ends(each, wanted)]
    if len(found) == 1:
        return Path(str(found[0].locate()))
    if found:
        names = ", ".join(map(str, found[:_SHOWN]))
        raise RobotError(f"the package {package!r} has several files {file}; give more of: {names}")
    stem = wanted[-1].partition(".")[0].lower()
    robots = [str(each) for each in files if each.suffix in (".urdf", ".xacro")]
    alike = [name for name in robots if stem in name.lower()] or robots
    names = ", ".join(alike[:_SHOWN]) + (", ..." if len(alike) > _SHOWN else "")
    raise RobotError(f"the package {package!r} has no file {file}; it has {names or 'no robot'}")


def _ends(path: PurePosixPath, wanted: tuple[str, ...]) -> bool:
    return path.parts[-len(wanted) :] == wanted
