"""The root of every error that MSMA raises on purpose."""


class MsmaError(Exception):
    """Something the user can correct: the message says what, where, and what would be valid.

    Every kind also inherits the builtin that fits it, so that callers can catch it without knowing
    MSMA: `class RobotError(MsmaError, ValueError)`.
    """
