"""A virtual host: the first process of its namespaces; all others end with it."""

import socket
import sys

from setproctitle import setproctitle

from runtime.spawning.host_server import serve


def main() -> int:
    """Serve the launcher: `host NAME`."""
    name = sys.argv[1]
    setproctitle(f"msma share {name}, a rehearsal's host")
    socket.sethostname(name)
    return serve(stays=False)


if __name__ == "__main__":
    sys.exit(main())
