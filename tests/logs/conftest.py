"""Logs and serialisers that the tests of this room share."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log, PoseSeries


def make_log(n: int = 50, n_joints: int = 2, seed: int = 1, sample_time: float = 5e-4) -> Log:
    rng = np.random.default_rng(seed)
    stamp = stamps_ns(n, sample_time)
    names = tuple(f"motor_{i + 1}" for i in range(n_joints))

    def draw(m: int) -> np.ndarray:
        return rng.normal(size=(n, m))

    return Log(
        joint_states=JointSeries(stamp, names, position=draw(n_joints)),
        joint_commands=JointSeries(stamp, names, effort=draw(n_joints)),
        joint_reference=JointSeries(stamp, names, draw(n_joints), draw(n_joints), draw(n_joints)),
        tool_pose=PoseSeries(stamp, "base", draw(3), draw(4)),
        tool_reference=PoseSeries(stamp, "base", draw(3), draw(4)),
        provenance={"scenario": "test", "seed": seed},
    )


@pytest.fixture(name="make_log")
def make_log_fixture():
    return make_log


@pytest.fixture(scope="session")
def store():
    """Typestore of ROS 2 Jazzy, the oracle of serialisation."""
    return get_typestore(Stores.ROS2_JAZZY)


@pytest.fixture(scope="session")
def joint_state(store):
    """Make a JointState of the oracle and its serialisation."""

    def make(stamp: int, names: list[str], position=(), velocity=(), effort=(), frame_id: str = "") -> Any:
        types = store.types
        sec, nanosec = divmod(stamp, 10**9)
        header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](sec, nanosec), frame_id)
        message = types["sensor_msgs/msg/JointState"](
            header, list(names), *(np.array(v, dtype=np.float64) for v in (position, velocity, effort))
        )
        return message, bytes(store.serialize_cdr(message, "sensor_msgs/msg/JointState"))

    return make


@pytest.fixture(scope="session")
def diagnostics(store):
    """Make a DiagnosticArray of the oracle from (node, message, values) each."""

    def make(*states: tuple[str, str, dict[str, str]], stamp: int = 10**9) -> Any:
        types = store.types
        header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9)), "")
        pair, status = types["diagnostic_msgs/msg/KeyValue"], types["diagnostic_msgs/msg/DiagnosticStatus"]
        return types["diagnostic_msgs/msg/DiagnosticArray"](
            header, [status(1, name, text, "x", [pair(*item) for item in v.items()]) for name, text, v in states]
        )

    return make


def assert_same_series(a, b) -> None:
    assert (a is None) == (b is None)
    if a is None:
        return
    np.testing.assert_array_equal(a.stamp, b.stamp)
    assert (a.received is None) == (b.received is None)
    if a.received is not None:
        np.testing.assert_array_equal(a.received, b.received)
    for name in ("names", "frame_id"):
        assert getattr(a, name, None) == getattr(b, name, None)
    for name in ("position", "velocity", "effort", "orientation"):
        left, right = getattr(a, name, None), getattr(b, name, None)
        assert (left is None) == (right is None), name
        if left is not None:
            np.testing.assert_array_equal(left, right)


@pytest.fixture
def assert_same_log():
    """Compare two logs topic by topic, bit by bit."""

    def check(a: Log, b: Log) -> None:
        for name in ("joint_states", "joint_commands", "joint_reference", "tool_pose", "tool_reference"):
            assert_same_series(getattr(a, name), getattr(b, name))

    return check
