"""Bags of other robots, written by rosbags: types, names, units and rates that are not ours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from flexros.errors import InputError
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.sources.ros_bag import RosBag
from flexros.logs.reader import read_log
from flexros.logs.write_log import write_log

pytestmark = pytest.mark.slow

WALL = 1_790_000_000_123_456_789
"""A time of today [ns]: as a float of seconds it is exact to 0.2 us only."""

JOINT_STATE = "sensor_msgs/msg/JointState"
FLOATS = "std_msgs/msg/Float64MultiArray"
DYNAMIC = "control_msgs/msg/DynamicJointState"
CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
POINT = "trajectory_msgs/msg/JointTrajectoryPoint"
DEFINITIONS = {
    "control_msgs/msg/InterfaceValue": "string[] interface_names\nfloat64[] values\n",
    DYNAMIC: "std_msgs/Header header\nstring[] joint_names\nInterfaceValue[] interface_values\n",
    CONTROLLER: (
        "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint reference\n"
        "trajectory_msgs/JointTrajectoryPoint feedback\ntrajectory_msgs/JointTrajectoryPoint error\n"
        "trajectory_msgs/JointTrajectoryPoint output\n"
    ),
}
Row = tuple[int, Any]


@pytest.fixture(scope="module")
def types():
    """Typestore of ROS 2 Jazzy with the messages of ros2_control added."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store


def header(types: Any, stamp: int) -> Any:
    time = types.types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9))
    return types.types["std_msgs/msg/Header"](time, "")


def joint_state(types: Any, stamp: int, names: Sequence[str], *values: Sequence[float]) -> Any:
    arrays = [np.array(value, float) for value in (*values, (), (), ())[:3]]
    return types.types[JOINT_STATE](header(types, stamp), list(names), *arrays)


def point(types: Any, positions: Sequence[float] = (), velocities: Sequence[float] = ()) -> Any:
    nothing = np.array([])
    duration = types.types["builtin_interfaces/msg/Duration"](0, 0)
    return types.types[POINT](np.array(positions, float), np.array(velocities, float), nothing, nothing, duration)


def bag(types: Any, folder: Path, topics: dict[str, tuple[str, list[Row]]]) -> Path:
    """Write a bag of topics with a type and rows of time of recording [ns] and message."""
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        rows = []
        for topic, (kind, messages) in topics.items():
            connection = writer.add_connection(topic, kind, typestore=types)
            rows += [(time, connection, types.serialize_cdr(message, kind)) for time, message in messages]
        for time, connection, data in sorted(rows, key=lambda row: row[0]):
            writer.write(connection, time, data)
    return folder


def column(name: str, quantity: str, unit: str, joint: str = "motor_1", **keys: Any) -> dict[str, Any]:
    return {"column": name, "quantity": quantity, "unit": unit, "joint": joint, **keys}


def test_other_names_order_units_and_rates(types, tmp_path: Path, mapping_of) -> None:
    step = 4_000_000
    names = ("wrist", "slide")
    states = [
        (WALL + k * step + 700, joint_state(types, WALL + k * step, names, (10.0 * k, 2.0 * k), (k, k), (0.5, k)))
        for k in range(100)
    ]
    commands = [
        (WALL + k * 2 * step, joint_state(types, WALL + k * 2 * step, names[::-1], (), (), (k, -k))) for k in range(50)
    ]
    folder = bag(types, tmp_path / "bag", {"/arm/state": (JOINT_STATE, states), "/arm/cmd": (JOINT_STATE, commands)})
    mapping = mapping_of(
        column("/arm/state.position[slide]", "position", "mm"),
        column("/arm/state.position[wrist]", "position", "deg", "motor_2", sign=-1, gear_ratio=10),
        column("/arm/cmd.effort[slide]", "torque_command", "kN"),
        column("/arm/cmd.effort[wrist]", "torque_command", "Nm", "motor_2"),
        time=None,
    )
    log = import_log(mapping, [folder])
    k = np.arange(100)
    np.testing.assert_allclose(log.joint_states.position, np.column_stack([2e-3 * k, -np.deg2rad(k)]), atol=1e-15)
    np.testing.assert_allclose(log.joint_commands.effort, np.column_stack([1e3 * k[:50], -k[:50]]), atol=1e-15)
    assert log.joint_states.names == ("motor_1", "motor_2")
    np.testing.assert_array_equal(log.joint_states.stamp, 10**9 + k * step)
    np.testing.assert_array_equal(log.joint_commands.stamp, 10**9 + k[:50] * 2 * step)
    assert log.warnings == ()
    assert log.provenance["import"]["time_of_first_row_s"] == pytest.approx(WALL * 1e-9, abs=1e-6)
    write_log(log, tmp_path / "ours")
    assert read_log(tmp_path / "ours").provenance["import"]["files"][0]["name"].endswith(".mcap")


def test_dynamic_joint_state_with_joints_in_changing_order(types, tmp_path: Path, mapping_of) -> None:
    values = types.types["control_msgs/msg/InterfaceValue"]
    messages = []
    for k in range(20):
        joints = [
            ("elbow", values(["position", "effort"], np.array([k * 0.1, 3.0]))),
            ("gpio", values(["on"], np.array([1.0]))),
            ("shoulder", values(["effort", "position"], np.array([7.0, -0.1 * k]))),
        ]
        if k % 2:
            joints.reverse()
        message = types.types[DYNAMIC](header(types, WALL + k * 10**6), *(list(each) for each in zip(*joints)))
        messages.append((WALL + k * 10**6, message))
    folder = bag(types, tmp_path / "bag", {"/dynamic_joint_states": (DYNAMIC, messages)})
    place = "/dynamic_joint_states.interface_values[{}].values[{}]"
    mapping = mapping_of(
        *(column(place.format(name, "position"), "position", "rad", f"motor_{i}") for i, name in JOINTS),
        *(column(place.format(name, "effort"), "measured_torque", "Nm", f"motor_{i}") for i, name in JOINTS),
        time=None,
    )
    log = import_log(mapping, [folder / "bag.mcap"])
    k = np.arange(20)
    np.testing.assert_allclose(log.joint_states.position, np.column_stack([-0.1 * k, 0.1 * k]))
    np.testing.assert_array_equal(log.joint_states.effort, np.tile([7.0, 3.0], (20, 1)))


JOINTS = ((1, "shoulder"), (2, "elbow"))


def test_joint_trajectory_controller_state_and_its_commands_without_header(types, tmp_path: Path, mapping_of) -> None:
    names, states, commands = ["shoulder", "elbow"], [], []
    layout = types.types["std_msgs/msg/MultiArrayLayout"]([], 0)
    for k in range(50):
        time = WALL + k * 2_000_000
        feedback, reference = point(types, [k, 2 * k], [1, 2]), point(types, [k + 1, 2 * k + 1], [1, 2])
        empty = point(types)
        states.append((time, types.types[CONTROLLER](header(types, time), names, reference, feedback, empty, empty)))
        commands.append((time + 300_000, types.types[FLOATS](layout, np.array([5.0 * k, -k]))))
    topics = {"/jtc/controller_state": (CONTROLLER, states), "/effort_controller/commands": (FLOATS, commands)}
    mapping = mapping_of(
        *(
            column(f"/jtc/controller_state.{part}[{name}]", quantity, unit, f"motor_{i}")
            for i, name in JOINTS
            for part, quantity, unit in (
                ("feedback.positions", "position", "rad"),
                ("feedback.velocities", "velocity", "rad/s"),
                ("reference.positions", "reference_position", "rad"),
            )
        ),
        *(
            column(f"/effort_controller/commands.data[{i - 1}]", "torque_command", "Nm", f"motor_{i}")
            for i, _ in JOINTS
        ),
        time=None,
    )
    log = import_log(mapping, [bag(types, tmp_path / "bag", topics)])
    k = np.arange(50)
    np.testing.assert_array_equal(log.joint_states.position, np.column_stack([k, 2 * k]))
    np.testing.assert_array_equal(log.joint_reference.position, np.column_stack([k + 1, 2 * k + 1]))
    np.testing.assert_array_equal(log.joint_commands.effort, np.column_stack([5 * k, -k]))
    np.testing.assert_array_equal(log.joint_commands.stamp - log.joint_states.stamp, 300_000)
    assert log.warnings == (
        "/effort_controller/commands has no header.stamp, or one that is not set: times of recording are used",
    )


def test_messages_out_of_order_and_repeated_are_sorted_and_reported(types, tmp_path: Path, mapping_of) -> None:
    stamps = [0, 2, 1, 3, 3]
    states = [(WALL + k, joint_state(types, WALL + stamp * 10**6, ["a"], [stamp])) for k, stamp in enumerate(stamps)]
    folder = bag(types, tmp_path / "bag", {"/s": (JOINT_STATE, states)})
    log = import_log(mapping_of(column("/s.position[a]", "position", "rad"), time=None), [folder])
    np.testing.assert_array_equal(log.joint_states.position[:, 0], [0, 1, 2, 3])
    assert log.warnings == ("/s.position[a]: 1 values with a repeated time were left out",)


def test_two_senders_that_take_turns_on_one_topic(types, tmp_path: Path, mapping_of) -> None:
    states = [
        (WALL + k * 10**6, joint_state(types, WALL + k * 10**6, ["finger" if k % 2 else "arm"], [k])) for k in range(20)
    ]
    folder = bag(types, tmp_path / "bag", {"/joint_states": (JOINT_STATE, states)})
    mapping = mapping_of(column("/joint_states.position[arm]", "position", "rad"), time=None)
    np.testing.assert_array_equal(import_log(mapping, [folder]).joint_states.position[:, 0], np.arange(0, 20, 2))


def test_names_of_a_bag_are_listed_where_one_is_unknown(types, tmp_path: Path, mapping_of) -> None:
    states = [(WALL + k, joint_state(types, WALL + k, ["a"], [k])) for k in range(5)]
    folder = bag(types, tmp_path / "bag", {"/s": (JOINT_STATE, states)})
    with pytest.raises(InputError, match=r"'/s.position\[b\]'.* did you mean '/s.position\[a\]'"):
        import_log(mapping_of(column("/s.position[b]", "position", "rad"), time=None), [folder])


def test_table_needs_a_clock_in_the_mapping(table, write_csv, tmp_path: Path, mapping_of) -> None:
    file = write_csv(tmp_path / "a.csv", table)
    with pytest.raises(InputError, match="mapping mine has no key time, but .*a.csv has no times of its own; add"):
        import_log(mapping_of(time=None), [file])


def test_bag_that_is_truncated_is_read_up_to_there(types, tmp_path: Path, mapping_of) -> None:
    n = 16_000
    states = [(WALL + k * 10**6, joint_state(types, WALL + k * 10**6, ["a"], [k])) for k in range(n)]
    whole = bag(types, tmp_path / "bag", {"/s": (JOINT_STATE, states)}) / "bag.mcap"
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size * 3 // 4])
    log = import_log(mapping_of(column("/s.position[a]", "position", "rad"), time=None), [cut])
    assert 2 <= len(log.joint_states.stamp) < n
    assert any("is truncated at byte" in warning for warning in log.warnings)


def test_pictures_and_unknown_encodings_have_no_names(types, tmp_path: Path) -> None:
    image = types.types["sensor_msgs/msg/Image"](header(types, WALL), 50, 50, "mono8", 0, 50, np.zeros(2500, np.uint8))
    folder = bag(types, tmp_path / "bag", {"/camera": ("sensor_msgs/msg/Image", [(WALL, image)])})
    assert RosBag(folder).names == tuple(f"/camera.{name}" for name in ("height", "width", "is_bigendian", "step"))
