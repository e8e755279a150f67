"""The guide's bridge to ros2_control, with a node in the place of its hardware interface."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
import pytest

from flexros.logs.reader import read_log

pytest.importorskip("rclpy", reason="needs ROS 2")

from flexros_nodes.plant.node import PlantNode
from flexros_nodes.recorder import RecorderNode

if TYPE_CHECKING:
    from rclpy.node import Node

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
TORQUE = 5.0
SAMPLES = 201
TIMEOUT = 60.0

StartProcess = Callable[..., subprocess.Popen[str]]


def hardware_interface(context: Any) -> Node:
    """Make a node that sends as the hardware interface does: depth 1, stamped with its own time; reads best effort."""
    from geometry_msgs.msg import PoseStamped
    from rclpy.node import Node
    from rclpy.qos import qos_profile_sensor_data
    from sensor_msgs.msg import JointState

    node = Node("hardware_interface", context=context)
    commands = node.create_publisher(JointState, "/ros2_control_commands", 1)

    def update(state: JointState) -> None:
        message = JointState(name=state.name, effort=[TORQUE])
        message.header.stamp = node.get_clock().now().to_msg()
        commands.publish(message)

    node.create_subscription(JointState, "/joint_states", update, qos_profile_sensor_data)
    # the plant counts its listeners on both topics, so that with `observers` it begins when this node hears it too
    node.create_subscription(PoseStamped, "/tool_pose", lambda _: None, qos_profile_sensor_data)
    return node


@pytest.mark.slow
def test_newest_command_answers_each_measurement(bench: Any, start_example: StartProcess, tmp_path: Path) -> None:
    scenario = tmp_path / "rest.yaml"
    scenario.write_text(
        f"robot: two_mass\nduration: {(SAMPLES - 1) * 1e-3}\nnoise: false\nfeedforward: {{method: none}}\n"
        "controller: {kind: pid, kp: 1}\n"
    )
    interface = hardware_interface(bench.context)
    bench.hold(interface)
    bridge = start_example("ros2_control_bridge.py")
    bench.spin_until(lambda: interface.count_subscribers("/ros2_control_commands") > 0, TIMEOUT)
    recorder = bench.add(RecorderNode, scenario=str(scenario), folder=str(tmp_path / "log"))
    plant = bench.add(PlantNode, scenario=str(scenario), observers=2)
    for node in (recorder, plant):
        node.trigger_configure()
        node.trigger_activate()
    bench.spin_until(lambda: plant.report is not None, TIMEOUT)
    assert (plant.report.exit_code, plant.report.message) == (0, "")
    recorder.trigger_shutdown()
    bridge.send_signal(signal.SIGTERM)
    _, errors = bridge.communicate(timeout=TIMEOUT)
    assert bridge.returncode == 0, errors
    log = read_log(tmp_path / "log")
    assert log.joint_commands is not None
    assert log.joint_commands.effort is not None
    np.testing.assert_array_equal(log.joint_commands.stamp, log.joint_states.stamp)
    effort = log.joint_commands.effort[:, 0]
    begin = int(np.argmax(effort == TORQUE))
    assert set(effort[:begin].tolist()) <= {0.0}
    assert begin < SAMPLES // 2
    assert set(effort[begin:].tolist()) == {TORQUE}


def test_urdf_of_the_guide_names_the_topics_and_one_effort_interface_for_each_motor() -> None:
    system = ElementTree.parse(EXAMPLES / "two_mass_ros2_control.urdf").getroot().find("ros2_control")
    assert system is not None
    parameters = {each.get("name"): each.text for each in system.iterfind("hardware/param")}
    assert parameters["joint_states_topic"] == "/joint_states"
    text = (EXAMPLES / "ros2_control_bridge.py").read_text(encoding="utf-8")
    assert f'"{(parameters["joint_commands_topic"] or "").strip("/")}"' in text
    joints = {each.get("name"): each for each in system.iterfind("joint")}
    assert list(joints) == ["motor_1"]
    assert [each.get("name") for each in joints["motor_1"].iterfind("command_interface")] == ["effort"]
