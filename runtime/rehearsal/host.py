"""A virtual host: the first process of its namespaces; all others end with it."""

import os
import signal
import socket
import sys

from setproctitle import setproctitle

from runtime.rehearsal.tap import open_tap
from runtime.spawning.host_server import serve


def main() -> int:
    """Open the TAP device, pass it on, and serve the launcher: `host NAME ADDRESS SOCKET`."""
    name, address, number = sys.argv[1:]
    setproctitle(f"msma share {name}, a rehearsal's host")
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the launcher handles Ctrl-C
    socket.sethostname(name)
    with socket.socket(fileno=int(number)) as sender:
        tap = open_tap(address)
        socket.send_fds(sender, [b"tap"], [tap])
        os.close(tap)
    return serve(stays=False)


if __name__ == "__main__":
    sys.exit(main())
