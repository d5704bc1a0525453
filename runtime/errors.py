"""What goes wrong while something runs, in contrast to bad input."""

from plant.errors import MsmaError


class RunError(MsmaError, RuntimeError):
    """A run that could not begin or go on, or that is not there: exit code 1."""
