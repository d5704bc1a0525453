"""What goes wrong while something runs, in contrast to bad input; the exit code of an error."""

import os
import sys
from collections.abc import Callable

from plant.errors import MsmaError


class RunError(MsmaError, RuntimeError):
    """A run that could not begin or go on, or that is not there: exit code 1."""


def exit_code(run: Callable[[], int]) -> int:
    """Return the exit code of what `run` does; of an error it prints a line and no traceback.

    2 for bad input, 1 for what failed while it ran, 130 when interrupted.
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
    except BrokenPipeError:  # the reader of our output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:  # a full disk, say
        if error.errno is None:  # it does not come from the system
            raise
        where = f"{error.filename}: " if error.filename else ""
        print(f"msma: {where}{error.strerror}", file=sys.stderr)
        return 1
