"""Whether only this user (or root) can change a file, which ssh asks of its keys too."""

import grp
import os
import pwd
import stat
from contextlib import suppress
from pathlib import Path


def distrust(path: Path) -> str | None:
    """Return why another user may change what is at an absolute path; None if none can.

    That goes for the file or folder, and for each folder that it is in.
    """
    for part in (path, *path.parents):
        try:
            status = part.lstat()
        except OSError as error:
            return f"{part}: {error.strerror}"
        if stat.S_ISLNK(status.st_mode):
            return f"{part} is a symbolic link"
        if status.st_uid not in (os.geteuid(), 0):
            with suppress(KeyError):
                return f"{part} belongs to user {part.owner()}"
            return f"{part} belongs to user {status.st_uid}"
        if stat.S_ISDIR(status.st_mode) and status.st_mode & stat.S_ISVTX:
            continue  # as /tmp: nobody can replace what others have in it
        if status.st_mode & stat.S_IWOTH:
            return f"{part} can be written by every user"
        if status.st_mode & stat.S_IWGRP and not _is_own_group(status.st_gid):
            return f"{part} can be written by its group"
    return None


def distrust_modules(folder: Path) -> str | None:
    """Return why another user may change a module that would be imported from a folder."""
    modules = (*folder.glob("*.py"), *folder.glob("*/__init__.py"))
    checked = (distrust(Path(os.path.realpath(file))) for file in (folder, *modules))
    return next((why for why in checked if why is not None), None)


def _is_own_group(gid: int) -> bool:
    """Tell whether a group has no member but this user, as many systems make one for each user."""
    try:
        user, group = pwd.getpwuid(os.geteuid()), grp.getgrgid(gid)
    except KeyError:
        return False
    named = (gid, group.gr_name) == (user.pw_gid, user.pw_name)
    return named and set(group.gr_mem) <= {user.pw_name}
