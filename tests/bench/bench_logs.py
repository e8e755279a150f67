"""Speed of logs compared with the reference implementation of MCAP, rosbags and rclpy, measured in the same run.

Prints a JSON list of rows; a row of a peer follows ours.
"""

from __future__ import annotations

import json
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from mcap.writer import Writer as McapWriter
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from flexros.config.topics import load_topics
from flexros.logs.messages.joint_state import JointStateCodec, JointStateTemplate, JointStateView
from flexros.logs.messages.joint_trajectory import (
    JointTrajectoryChunk,
    read_joint_trajectory,
    serialise_joint_trajectory,
)
from flexros.logs.messages.schemas import message_schema
from flexros.logs.reader import read_log
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log, PoseSeries
from flexros.logs.write_log import write_log
from flexros.logs.writer import LogWriter

if TYPE_CHECKING:
    from collections.abc import Callable

N = 80_000
N_PEER = 4_000
NAMES = ("motor_1", "motor_2")
TOPICS = ("joint_states", "joint_commands", "joint_reference", "tool_pose", "tool_reference")


def per_message(function: Callable[[], object], n: int, repeats: int = 3) -> float:
    """Best time of a few runs [us per message]."""
    best = np.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        function()
        best = min(best, time.perf_counter() - begin)
    return best / n * 1e6


def rows(case: str, ours: float, peers: dict[str, float], goal: float | None = None) -> list[dict[str, object]]:
    """Our time and that of the peers [us]."""
    named = {"flexros": ours, **peers}
    return [
        {
            "bench": "logs",
            "case": case,
            "what": name,
            "value": float(f"{value:.4g}"),
            "unit": "us",
            "goal": goal if name == "flexros" else None,
        }
        for name, value in named.items()
    ]


def make_log() -> Log:
    rng = np.random.default_rng(0)
    stamp = stamps_ns(N, 5e-4)

    def walk(n_columns: int) -> np.ndarray:
        return np.cumsum(rng.normal(size=(N, n_columns)), axis=0)

    return Log(
        JointSeries(stamp, NAMES, walk(2)),
        JointSeries(stamp, NAMES, effort=walk(2)),
        JointSeries(stamp, NAMES, walk(2), walk(2), walk(2)),
        PoseSeries(stamp, "base", walk(3), walk(4)),
        PoseSeries(stamp, "base", walk(3), walk(4)),
    )


def message_rows() -> list[dict[str, object]]:
    """Filling and reading one JointState of two joints with three fields."""
    store = get_typestore(Stores.ROS2_JAZZY)
    template, view = JointStateTemplate(NAMES, position=True, velocity=True, effort=True), JointStateView(NAMES)
    values = np.array([0.1, 0.2])
    payload = template.fill(10**9, values, values, values)
    message = store.deserialize_cdr(payload, JointStateCodec.type)
    k = range(N_PEER)
    fill = per_message(lambda: [template.fill(10**9 + i, values, values, values) for i in k], N_PEER)
    read = per_message(lambda: [view.unpack(payload) for _ in k], N_PEER)
    fill_peers = {
        "rosbags": per_message(lambda: [store.serialize_cdr(message, JointStateCodec.type) for _ in k], N_PEER)
    }
    read_peers = {
        "rosbags": per_message(lambda: [store.deserialize_cdr(payload, JointStateCodec.type) for _ in k], N_PEER)
    }
    if find_spec("rclpy"):
        from rclpy.serialization import deserialize_message, serialize_message
        from sensor_msgs.msg import JointState

        ros = deserialize_message(payload, JointState)
        fill_peers["rclpy"] = per_message(lambda: [serialize_message(ros) for _ in k], N_PEER)
        read_peers["rclpy"] = per_message(lambda: [deserialize_message(payload, JointState) for _ in k], N_PEER)
    return [*rows("fill a JointState", fill, fill_peers, 1.5), *rows("read a JointState", read, read_peers)]


def trajectory_rows() -> list[dict[str, object]]:
    """A chunk of 200 points of two joints with three fields."""
    store = get_typestore(Stores.ROS2_JAZZY)
    numbers = np.random.default_rng(0).normal(size=(3, 200, 2))
    chunk = JointTrajectoryChunk(10**9, NAMES, np.arange(200) * 500_000, numbers[0], numbers[1], effort=numbers[2])
    payload, kind = serialise_joint_trajectory(chunk), "trajectory_msgs/msg/JointTrajectory"
    message = store.deserialize_cdr(payload, kind)
    return [
        *rows(
            "fill 200 trajectory points",
            per_message(lambda: [serialise_joint_trajectory(chunk) for _ in range(100)], 100),
            {"rosbags": per_message(lambda: [store.serialize_cdr(message, kind) for _ in range(20)], 20)},
            100.0,
        ),
        *rows(
            "read 200 trajectory points",
            per_message(lambda: [read_joint_trajectory(payload) for _ in range(100)], 100),
            {"rosbags": per_message(lambda: [store.deserialize_cdr(payload, kind) for _ in range(20)], 20)},
            100.0,
        ),
    ]


def recorder_rows(folder: Path) -> list[dict[str, object]]:
    """Five topics of JointState messages through the recorder's writer, until the log is closed."""
    template = JointStateTemplate(NAMES, position=True, velocity=True, effort=True)
    values = np.random.default_rng(0).normal(size=(N, 6)).tolist()
    stamps = stamps_ns(N, 5e-4).tolist()
    payloads = [template.fill(s, v[:2], v[2:4], v[4:]) for s, v in zip(stamps, values, strict=True)]
    topic = load_topics()["joint_states"]
    topics = [topic.model_copy(update={"name": name}) for name in TOPICS]
    runs = iter(range(10))

    def ours() -> None:
        with LogWriter(folder / f"ours_{next(runs)}", topics, {}) as writer:
            write = writer.write
            for stamp, payload in zip(stamps, payloads, strict=True):
                for number in (1, 2, 3, 4, 5):
                    write(number, stamp, stamp, payload)

    def theirs() -> None:
        with (folder / "theirs.mcap").open("wb") as stream:
            writer = McapWriter(stream)
            writer.start("ros2")
            schema = writer.register_schema(
                JointStateCodec.type, "ros2msg", message_schema(JointStateCodec.type).text.encode()
            )
            channels = [writer.register_channel(name, "cdr", schema) for name in TOPICS]
            for stamp, payload in zip(stamps[:N_PEER], payloads[:N_PEER], strict=True):
                for channel in channels:
                    writer.add_message(channel, stamp, payload, stamp)
            writer.finish()

    return rows("record a message", per_message(ours, 5 * N), {"mcap": per_message(theirs, 5 * N_PEER)}, 1.0)


def log_rows(folder: Path) -> list[dict[str, object]]:
    """A log of 80,000 samples and five topics, written at once and read."""
    log = make_log()
    runs = iter(range(10))
    write = per_message(lambda: write_log(log, folder / f"log_{next(runs)}"), 5 * N)

    def theirs() -> None:
        with AnyReader([folder / "log_0"]) as reader:
            for k, (connection, _, payload) in enumerate(reader.messages()):
                reader.deserialize(payload, connection.msgtype)
                if k == 5 * N_PEER:
                    break

    read = per_message(lambda: read_log(folder / "log_0"), 5 * N)
    return [
        *rows("write a whole log, per message", write, {}, 5.0),
        *rows("read a log, per message", read, {"rosbags": per_message(theirs, 5 * N_PEER)}, 2.5),
    ]


def main() -> None:
    """Print all rows."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print(json.dumps([*message_rows(), *trajectory_rows(), *recorder_rows(folder), *log_rows(folder)]))


if __name__ == "__main__":
    main()
