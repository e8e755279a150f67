"""Frames of the true arm; tf2_msgs is on no package index, so a stand-in with its one field is used."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

from flexros.errors import InputError
from flexros.robot import load_robot
from flexros_nodes.plant.arm_frames import ArmFrames
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.shell.topic_interface import message_class

HAS_TF2 = importlib.util.find_spec("tf2_msgs") is not None


@dataclass
class TFMessage:
    transforms: list[Any]


@pytest.fixture
def tf2_msgs(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    module = ModuleType("tf2_msgs.msg")
    module.TFMessage = TFMessage  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "tf2_msgs", ModuleType("tf2_msgs"))
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", module)
    message_class.cache_clear()
    yield
    message_class.cache_clear()


@pytest.mark.usefixtures("tf2_msgs")
def test_frames_are_those_of_the_state() -> None:
    q_a = np.array([0.1, 0.4, -0.2])
    message = ArmFrames(load_robot("e12"), "true/").fill(1_500_000_000, q_a)
    assert [stamped.child_frame_id for stamped in message.transforms] == ["true/body_1", "true/body_2", "true/body_3"]
    second = message.transforms[1]
    assert (second.header.frame_id, second.header.stamp.sec, second.header.stamp.nanosec) == ("base", 1, 500_000_000)
    place, turn = second.transform.translation, second.transform.rotation
    np.testing.assert_allclose([place.x, place.y, place.z], [np.cos(0.1), 0, -np.sin(0.1)], atol=1e-12)
    np.testing.assert_allclose([turn.x, turn.y, turn.z, turn.w], [0, np.sin(0.25), 0, np.cos(0.25)], atol=1e-12)


@pytest.mark.skipif(HAS_TF2, reason="tells what happens without tf2_msgs, which is here")
def test_frames_without_their_type_are_refused(bench: Any) -> None:
    with pytest.raises(
        InputError, match=r"frames of node plant is true, but /tf needs tf2_msgs, which cannot be impor"
    ):
        ArmFrames(load_robot("e12"), "true/")
    plant = bench.add(PlantNode, frames=True)
    plant.trigger_configure()
    assert plant.report.exit_code == 2


@pytest.mark.skipif(not HAS_TF2, reason="needs tf2_msgs, which only a full ROS 2 has")
def test_frames_reach_a_listener(bench: Any) -> None:
    from rclpy.node import Node
    from tf2_msgs.msg import TFMessage as Message

    plant = bench.add(PlantNode, frames=True)
    listener = bench.hold(Node("listener", context=bench.context))
    heard: list[Any] = []
    listener.create_subscription(Message, "/tf", heard.append, 100)
    plant.trigger_configure()
    plant.trigger_activate()
    bench.spin_until(lambda: bool(heard))
    assert len(heard[0].transforms) == 3
