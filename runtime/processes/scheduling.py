"""Who goes first where processors are short: a robot's processes, before what can wait."""

import os

_LOWEST = 1  # of the priorities in real time: drivers and sound go before a robot's agents


def set_realtime() -> bool:
    """Have this thread, and those it starts, scheduled in real time; tell whether that is granted.

    So no other program holds a command up. And of a robot's processes none interrupts another
    (SCHED_RR): that costs what the processor has in its caches, and a tick wakes nine processes.
    The system grants it to root and to whom it gives `rtprio`, and keeps a share of each processor
    for the rest. Without it all goes on as any program does.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(_LOWEST))
    except (AttributeError, OSError):  # this system has no such thing, or does not grant it
        return False
    return True
