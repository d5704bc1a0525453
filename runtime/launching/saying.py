"""Printing that goes on when nobody reads any more: a run does not end because a pipe does."""

import os
import sys


def say(text: str) -> None:
    """Print a text at once; into nothing once the reader of a pipe has gone."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
