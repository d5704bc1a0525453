"""The root of every error that MSMA raises on purpose."""


class MsmaError(Exception):
    """Something the user can put right: the message says what, where, and what would be valid.

    Every kind also inherits the builtin that fits it, so that callers who know nothing of MSMA
    can still catch it: `class RobotError(MsmaError, ValueError)`.
    """
