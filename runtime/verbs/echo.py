"""Print the messages on a topic, decoded, as lines of JSON."""

import argparse
import itertools
import json

from msgspec import to_builtins

from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.wire import topics
from runtime.wire.packing import unpack, unpack_map
from runtime.wire.refusals import MessageError

_DEPTH = 1000  # messages waiting to be printed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-n", metavar="COUNT", type=int, default=0, help="stop after this many messages"
    )
    topic = "such as goal, arm/ee_pose, arm/joint/*/cmd, or ** for all"
    add_target_options(parser, topic=topic)


def run(args: argparse.Namespace) -> int:
    """Print until there were enough messages, or Ctrl-C."""
    with visit(target_of(args)) as bus:
        ring = bus.ring(args.topic, _DEPTH)
        for _ in range(args.n) if args.n else itertools.count():
            print(decoded(*ring.recv()), flush=True)
    return 0


def decoded(key: str, data: bytes) -> str:
    """Return a message as JSON with its names on the wire, or with the error in it.

    A message on a topic of the robot's own is printed as it is, up to a limit of its size.
    """
    topic = topics.STANDARD.topic_of(key)
    try:
        wire = unpack_map(data) if topic is None else to_builtins(unpack(topic.message, data))
        return json.dumps({"key": key, **wire})
    except (MessageError, TypeError) as error:
        return json.dumps({"key": key, "bytes": len(data), "error": str(error)})
