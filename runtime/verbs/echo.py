"""Print the messages on a key as they come, decoded, a line of JSON each."""

import argparse
import json
import queue

from msgspec import to_builtins

from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.wire import topics
from runtime.wire.messages import unpack, unpack_map
from runtime.wire.refusals import MessageError

_DEPTH = 1000  # messages that may wait to be printed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add which robot, which keys and how many."""
    parser.add_argument(
        "key", metavar="KEY", help="such as goal, arm/ee_pose, arm/joint/*/cmd, or ** for all"
    )
    parser.add_argument("-n", metavar="COUNT", type=int, default=0, help="end after so many")
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Print until there were enough, or Ctrl-C."""
    waiting: queue.Queue[tuple[str, bytes]] = queue.Queue(_DEPTH)

    def take(key: str, data: bytes) -> None:
        if not waiting.full():
            waiting.put_nowait((key, data))

    with visit(target_of(args)) as bus:
        bus.subscribe(args.key, take)
        count = 0
        while count < args.n or not args.n:
            print(decoded(*waiting.get()), flush=True)
            count += 1
    return 0


def decoded(key: str, data: bytes) -> str:
    """Return a message as JSON with the names that it has on the wire, or why it is none.

    A topic of the robot's own is printed as it is, of bounded size.
    """
    topic = topics.STANDARD.topic_of(key)
    try:
        wire = unpack_map(data) if topic is None else to_builtins(unpack(topic.message, data))
        return json.dumps({"key": key, **wire})
    except (MessageError, TypeError) as error:
        return json.dumps({"key": key, "bytes": len(data), "error": str(error)})
