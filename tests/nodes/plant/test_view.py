"""Visualisation of the plant: robot description and markers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.robot import load_robot
from flexros.robot.arm_view import ArmView
from flexros.robot.exchange.urdf.export import urdf_text

pytest.importorskip("rclpy", reason="needs ROS 2")

from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import String
from visualization_msgs.msg import Marker, MarkerArray

from flexros_nodes.plant import view as plant_view
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.shell.topic_interface import qos_profile, topic


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


def points(marker: Marker) -> Any:
    return np.array([[point.x, point.y, point.z] for point in marker.points]).reshape(-1, 2, 3)


def test_markers_show_the_state_of_the_plant(bench: Any) -> None:
    plant = bench.add(PlantNode)
    viewer = bench.hold(Node("viewer", context=bench.context))
    heard: list[MarkerArray] = []
    viewer.create_subscription(MarkerArray, "arm_markers", heard.append, qos_profile(topic("arm_markers").qos))
    plant.trigger_configure()
    plant.trigger_activate()
    bench.spin_until(lambda: bool(heard))
    assert plant.set_parameters([Parameter("magnification", value=1000.0)])[0].successful
    heard.clear()
    bench.spin_until(lambda: bool(heard))
    bars = ArmView(load_robot("e12")).bars(plant.loop.plant.state, 1000.0)
    assert [marker.ns for marker in heard[-1].markers] == ["true", "magnified", "stiff"]
    for marker in heard[-1].markers:
        assert (marker.header.frame_id, marker.header.stamp.sec) == ("base", 1)
        np.testing.assert_allclose(points(marker), getattr(bars, marker.ns), atol=1e-12)


def test_nothing_is_computed_without_subscribers(bench: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    plant = bench.add(PlantNode)
    plant.trigger_configure()
    view, robot = plant.view, plant.loop.plant
    count = view.publisher.get_subscription_count
    monkeypatch.setattr(view.publisher, "get_subscription_count", lambda: asked.append(1) or count())
    monkeypatch.setattr(plant_view, "ArmMarkers", None)
    for _ in range(2 * plant_view.CHECK_EVERY):
        view.show(robot)
    assert len(asked) == 2
