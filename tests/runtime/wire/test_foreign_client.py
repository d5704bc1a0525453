"""A client that knows the wire contract alone: written with zenoh and msgpack, nothing of ours."""

import os
import subprocess
import sys
from pathlib import Path

from tests.runtime.conftest import ProcessGroup

CLIENT = """
import json, math, os, sys, time
import msgpack, zenoh

robot, port = sys.argv[1:]
config = zenoh.Config()
config.insert_json5("mode", '"peer"')
config.insert_json5("namespace", json.dumps(robot))
config.insert_json5("listen/endpoints", '["tcp/127.0.0.1:0"]')
config.insert_json5("connect/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
config.insert_json5("scouting/multicast/enabled", "false")
by = int.from_bytes(os.urandom(7), "big")
deadline = time.monotonic() + 30
with zenoh.open(config) as session:
    ring = zenoh.handlers.RingChannel
    states = session.declare_subscriber("arm/joint_states", ring(1))
    poses = session.declare_subscriber("arm/ee_pose", ring(1))
    known = session.declare_subscriber("goal/known", ring(1))
    pose, goal, first = None, None, None
    for n in range(1, 100_000):
        assert time.monotonic() < deadline, (first, pose, goal)
        state = msgpack.unpackb(states.recv().payload.to_bytes())
        assert len(state["position"]) == len(state["velocity"]) == 6, state
        assert {"t", "by", "n"} <= state.keys(), state
        first = first or state
        stamp = {"t": state["t"], "by": by, "n": n}
        session.put("arm/joint/1/cmd", msgpack.packb({"velocity": 0.2, **stamp}))
        piece = {"position": [0.2, 0, 0.8], "velocity": [0.0, 0.0, 0.1], "from": 0, "until": 9.5}
        session.put("goal", msgpack.packb({**piece, **stamp, "a later field": None}))
        if sample := poses.try_recv():
            pose = msgpack.unpackb(sample.payload.to_bytes())
        if sample := known.try_recv():
            goal = msgpack.unpackb(sample.payload.to_bytes())
        moved = state["position"][0] - first["position"][0]
        if moved > 0.05 and pose and goal:
            break
assert len(pose["position"]) == 3, pose
assert math.isclose(sum(x * x for x in pose["orientation"]), 1, abs_tol=1e-3), pose
assert {key: goal[key] for key in piece} == piece, goal
assert not [name for name in sys.modules if name.split(".")[0] in ("runtime", "agents", "plant")]
print("moved the joint, saw the end effector, and published a goal")
"""


def test_a_client_of_zenoh_and_msgpack_alone_moves_a_joint_and_publishes_a_goal(
    processes: ProcessGroup, tmp_path: Path
) -> None:
    processes.start("plant")
    bus = processes.visit()
    processes.until(bus, "plant", lambda diag: True, "is there")
    file = tmp_path / "client.py"
    file.write_text(CLIENT)
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(
        [sys.executable, str(file), processes.robot, str(processes.port)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.stdout.startswith("moved the joint"), done.stderr
    diag = processes.until(bus, "plant", lambda diag: "joint/1" in diag.answers, "is answered")
    assert not diag.refused
