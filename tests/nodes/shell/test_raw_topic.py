"""Publishers of types that a log names."""

from __future__ import annotations

import sys

import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from std_msgs.msg import String

from flexros.logs.replay.recorded_topic import RecordedTopic
from flexros_nodes.shell.raw_topic import MissingTypeError, installed_class, played_qos


def test_an_installed_type_is_found() -> None:
    assert installed_class("std_msgs/msg/String") is String


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("nowhere_msgs/msg/Thing", "the package nowhere_msgs of its type nowhere_msgs/msg/Thing is not installed here"),
        ("std_msgs/msg/Strings", "its type std_msgs/msg/Strings cannot be used here"),
        ("std_msgs/srv/String", "the package std_msgs of its type std_msgs/srv/String is not installed here"),
        ("std_srvs/srv/Trigger", "its type std_srvs/srv/Trigger cannot be used here"),
        ("sys/msg/String", "the package sys of its type sys/msg/String is not installed here"),
    ],
)
def test_others_are_refused_with_a_reason(name: str, sentence: str) -> None:
    with pytest.raises(MissingTypeError, match=sentence):
        installed_class(name)


def test_a_package_that_is_none_of_ros_is_not_imported() -> None:
    assert "antigravity" not in sys.modules
    with pytest.raises(MissingTypeError):
        installed_class("antigravity/msg/String")
    assert "antigravity" not in sys.modules


@pytest.mark.parametrize("best_effort", [True, False])
@pytest.mark.parametrize("latched", [True, False])
def test_a_publisher_offers_what_was_offered(best_effort: bool, latched: bool) -> None:
    profile = played_qos(RecordedTopic("/a", "std_msgs/msg/String", best_effort=best_effort, latched=latched))
    assert (profile.reliability is ReliabilityPolicy.BEST_EFFORT) == best_effort
    assert (profile.durability is DurabilityPolicy.TRANSIENT_LOCAL) == latched
    assert profile.depth == 2000
