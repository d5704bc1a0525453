"""Makes the page of a rehearsal reachable: from this machine into the network of the page's host.

It is started in that network with a socket that listens outside of it, for a socket stays in the
network namespace in which it was made. It ends with its launcher, when its standard input closes.
"""

import asyncio
import socket
import sys
from contextlib import closing, suppress
from functools import partial

from setproctitle import setproctitle

from runtime.wire.mesh import LOOPBACK

_CHUNK = 65536  # [bytes] read at once


async def _connect(
    port: int, outside: asyncio.StreamReader, to_outside: asyncio.StreamWriter
) -> None:
    """Connect who came from outside to a port of this network, until both have ended."""
    with closing(to_outside), suppress(OSError):  # nobody listens at the port, or one is gone
        inside, to_inside = await asyncio.open_connection(LOOPBACK, port)
        with closing(to_inside):
            await asyncio.gather(_pipe(outside, to_inside), _pipe(inside, to_outside))


async def _pipe(source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
    """Pass on what comes until its end, and then that end."""
    while data := await source.read(_CHUNK):
        sink.write(data)
        await sink.drain()
    sink.write_eof()


async def _forward(listener: socket.socket, port: int) -> None:
    """Connect all who come to a listening socket, until standard input closes."""
    ended = asyncio.Event()
    asyncio.get_running_loop().add_reader(sys.stdin, ended.set)
    server = await asyncio.start_server(partial(_connect, port), sock=listener)
    await ended.wait()
    server.close()


def main() -> None:
    """Forward: `forwarder FILE PORT`, with the descriptor of a socket that listens."""
    setproctitle("msma rehearsal page")
    file, port = map(int, sys.argv[1:])
    asyncio.run(_forward(socket.socket(fileno=file), port))


if __name__ == "__main__":
    main()
