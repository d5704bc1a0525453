"""Errors at run time, in contrast to bad input; exit codes; hints for unknown names."""

import os
import sys
from collections.abc import Callable, Iterable

from plant.errors import MsmaError


class RunError(MsmaError, RuntimeError):
    """A failure at run time, or a run that does not exist: exit code 1."""


class NotConfirmed(RunError):
    """No plant has said in time that it has acted on a request."""

    def __init__(self, timeout: float) -> None:
        super().__init__(
            f"NOT CONFIRMED: no plant has answered within {timeout:g} s, and the robot may go on "
            f"as before: use the hardware stop"
        )


def exit_code(run: Callable[[], int]) -> int:
    """Return the exit code of a command; print an error as one line without a traceback.

    It is 2 for bad input, 1 for a failure at run time, 130 if interrupted, else what `run` returns.
    """
    try:
        code = run()
        sys.stdout.flush()
        return code
    except MsmaError as error:
        print("msma:", " ".join(str(error).splitlines()), file=sys.stderr)
        return 1 if isinstance(error, RunError) else 2
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # such as `msma echo ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:  # such as a full disk
        if error.errno is None:  # not from a system call
            raise
        where = f"{error.filename}: " if error.filename else ""
        print(f"msma: {where}{error.strerror}", file=sys.stderr)
        return 1


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" for the closest valid name, or an empty string."""
    names = list(valid)
    if not names:
        return ""
    import difflib  # slow to import, and needed for errors only

    close = difflib.get_close_matches(name, names, n=1)
    return f"; did you mean {close[0]!r}?" if close else ""


def valid_are(name: str, valid: Iterable[str]) -> str:
    """Return the hint after an error about an unknown name: the closest and all valid names."""
    names = list(valid)
    return f"{nearest(name, names) or ';'} valid are {', '.join(names) or 'none'}"
