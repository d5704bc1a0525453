"""What to say of a name that is none of the valid ones."""

from collections.abc import Iterable


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" for the likeliest of the valid names, or nothing."""
    names = list(valid)
    if not names:
        return ""
    import difflib  # only a mistake needs it

    close = difflib.get_close_matches(name, names, n=1)
    return f"; did you mean {close[0]!r}?" if close else ""


def valid_are(name: str, valid: Iterable[str]) -> str:
    """Return what to put after the complaint that `name` is none of the valid ones."""
    names = list(valid)
    return f"{nearest(name, names) or ';'} valid are {', '.join(names) or 'none'}"
