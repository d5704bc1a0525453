"""What Zenoh logs of strangers, which is the one place where it tells of them."""

import json
import os
import subprocess
import sys
from typing import Any

from runtime.wire.zenoh_internals.connection_log import REJECTED_CONNECTIONS
from tests.runtime.conftest import ROOT

SAID = """
import json, os, sys
from runtime.wire.refusals import Refusals
from runtime.wire.zenoh_internals.connection_log import ConnectionLog
refusals = Refusals()
joined = []
with ConnectionLog(refusals, lambda *who: joined.append(who)) as strangers:
    print("an agent's own words")
    sys.stdout.flush()
    for line in sys.stdin:
        os.write(1, line.encode())
        strangers.look()
print(json.dumps([refusals.table(), joined]), file=sys.stderr)
"""
LINES = {
    "peer sent no certificates": "no certificate",
    "received corrupt message of type": "not TLS",
    "something new": "no proper connection",
}


START = "2026-11-21T03:14:18.21Z  WARN acc-0 ThreadId(06) zenoh_link_tls::unicast: "
CAME = "Accepted TLS connection on 127.0.0.1:9501: 127.0.0.1:55132. Common Name: joint/1."
TRACED = "2026-11-21T03:14:18Z TRACE rx-1 ThreadId(17) zenoh::net::routing::interceptor::"
OTHERS = ["not a line of a log", "2026-11-21T03:14:18Z  WARN zenoh::api: another matter"]
ABOUT = [START.replace("WARN", "DEBUG") + CAME, *(START + line for line in LINES)]


def listen(lines: list[str], **environment: str) -> tuple[list[str], list[Any]]:
    """Return what is passed on of some lines of a log, and what is counted and who joined."""
    done = subprocess.run(
        [sys.executable, "-c", SAID],
        input="\n".join(lines) + "\n",
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        text=True,
    )
    said, *passed_on = done.stdout.splitlines()
    assert said == "an agent's own words", done.stderr
    return passed_on, json.loads(done.stderr)


def test_of_zenoh_s_log_all_that_is_not_about_strangers_goes_where_it_was_meant_to() -> None:
    passed_on, counted = listen(ABOUT + OTHERS)
    assert passed_on == OTHERS
    expected = {REJECTED_CONNECTIONS: dict.fromkeys(LINES.values(), 1)}
    assert counted == [expected, [["joint/1", "127.0.0.1:55132"]]]


def test_who_asks_zenoh_to_tell_more_gets_it_all_and_it_is_counted_as_before() -> None:
    told = [*ABOUT, f"{TRACED}access_control: x is authorized to Put (ingress) on arph/goal"]
    passed_on, (counted, _) = listen(told + OTHERS, RUST_LOG="trace")
    assert passed_on == told + OTHERS
    assert counted == {REJECTED_CONNECTIONS: dict.fromkeys(LINES.values(), 1)}
