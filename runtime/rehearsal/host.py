"""A host of a rehearsal: the first process of its namespaces, with whose end all others end."""

import os
import signal
import socket
import sys

from setproctitle import setproctitle

from runtime.rehearsal.tap import open_cable
from runtime.spawning.host_server import serve


def main() -> int:
    """Plug in the cable, give its other end away, and do a share: `host NAME ADDRESS SOCKET`."""
    name, address, number = sys.argv[1:]
    setproctitle(f"msma share {name}, a rehearsal's host")
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the launcher
    socket.sethostname(name)
    with socket.socket(fileno=int(number)) as giver:
        cable = open_cable(address)
        socket.send_fds(giver, [b"cable"], [cable])
        os.close(cable)
    return serve(stays=False)


if __name__ == "__main__":
    sys.exit(main())
