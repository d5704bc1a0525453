"""A program that looks at a robot's page, as an open browser does, in place of a heavier one.

It answers each state as if it had painted it. `python -m bench.page_viewer RUN` goes on for as long
as the page is there, in a folder of a run.
"""

import json
import sys
import time
from contextlib import suppress
from pathlib import Path

from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from nodes.hmi.address import Address, find_address
from runtime.processes.scheduling import set_normal

_AGAIN = 0.1  # [s] until a page that is not there yet is looked for again


def main() -> None:
    """Look at the page of the run that the command line names."""
    set_normal()  # as a browser has
    run = Path(sys.argv[1])
    while True:
        if (address := find_address(run)) is not None:
            with suppress(OSError, WebSocketException):  # it comes again, or this ends too
                look(address)
        time.sleep(_AGAIN)


def look(address: Address) -> None:
    """Look until the connection ends."""
    url = f"{address.origin.replace('http', 'ws', 1)}/socket"
    cookie = {"Cookie": f"msma-{address.port}={address.operator}"}
    more = {"origin": Origin(address.origin), "additional_headers": cookie, "compression": None}
    opened: ClientConnection = connect(url, **more)  # type: ignore[arg-type]
    with opened as socket:
        for frame in socket:
            message = json.loads(frame)
            if message["type"] == "state":
                socket.send(json.dumps({"type": "painted", "state": message["number"]}))


if __name__ == "__main__":
    main()
