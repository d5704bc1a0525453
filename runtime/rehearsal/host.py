"""A virtual host: the first process of its namespaces; all others end with it."""

import os
import socket
import sys

from setproctitle import setproctitle

from runtime.chaos.partition_requests import REHEARSAL
from runtime.spawning.host_server import serve


def main() -> int:
    """Serve the launcher: `host NAME`."""
    name = sys.argv[1]
    setproctitle(f"msma share {name}, a rehearsal's host")
    socket.sethostname(name)
    os.environ[REHEARSAL] = "1"  # of all processes here
    return serve(stays=False)


if __name__ == "__main__":
    sys.exit(main())
