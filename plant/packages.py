"""Robot descriptions inside installed Python packages, such as `example-robot-data`."""

import csv
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
    from importlib import metadata  # slow to import, and few robots are in a package

    try:
        installed = metadata.distribution(package)
    except metadata.PackageNotFoundError:
        raise RobotError(
            f"the package {package!r} is not installed; `pip install {package}` installs it"
        ) from None
    # its own list of files: `installed.files` parses more, and takes 50 ms for thousands
    rows = csv.reader((installed.read_text("RECORD") or "").splitlines())
    files = [row[0] for row in rows if row]
    wanted = PurePosixPath(file).parts or (file,)
    named = [each for each in files if each.endswith(wanted[-1])]
    found = [each for each in named if PurePosixPath(each).parts[-len(wanted) :] == wanted]
    if len(found) == 1:
        return Path(str(installed.locate_file(found[0])))
    if found:
        names = ", ".join(found[:_SHOWN])
        raise RobotError(f"the package {package!r} has several files {file}; give more of: {names}")
    stem = wanted[-1].partition(".")[0].lower()
    robots = [each for each in files if each.endswith((".urdf", ".xacro"))]
    alike = [name for name in robots if stem in name.lower()] or robots
    names = ", ".join(alike[:_SHOWN]) + (", ..." if len(alike) > _SHOWN else "")
    raise RobotError(f"the package {package!r} has no file {file}; it has {names or 'no robot'}")
