"""What others see of the plant: the description of its robot."""

from __future__ import annotations

from typing import Any

import pytest

from flexros.robot import load_robot
from flexros.robot.urdf_file import urdf_text

pytest.importorskip("rclpy", reason="needs ROS 2")

from rclpy.node import Node
from std_msgs.msg import String

from flexros_nodes.plant import PlantNode
from flexros_nodes.topic_interface import qos_profile, topic


@pytest.mark.parametrize("joints", ["fixed", "continuous"])
def test_description_reaches_who_asks_late(bench: Any, joints: str) -> None:
    plant = bench.add(PlantNode, description_joints=joints)
    plant.trigger_configure()
    late = bench.hold(Node("late", context=bench.context))
    heard: list[str] = []
    profile = qos_profile(topic("robot_description").qos)
    late.create_subscription(String, "robot_description", lambda message: heard.append(message.data), profile)
    bench.spin_until(lambda: bool(heard))
    assert heard == [urdf_text(load_robot("e12"), joints)]
