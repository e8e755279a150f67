"""Topics and QoS of `msgs_config` as ROS 2 types and profiles."""

from __future__ import annotations

from functools import cache
from importlib import import_module

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from flexros.config.topics import QosProfile, Topic, load_topics
from flexros.errors import unknown_name


def topic(name: str) -> Topic:
    """Give a row of `topics.yaml` by its name without a leading slash.

    Raises:
        InputError: There is no such topic.
    """
    topics = load_topics()
    if name not in topics:
        raise unknown_name("topic", name, topics, "msgs_config/topics.yaml")
    return topics[name]


def period(name: str) -> float:
    """Give the time between two messages of a topic that has a rate [s]."""
    return 1.0 / (topic(name).rate or 1.0)


EVENT_TYPES = ("diagnostic_msgs/msg/DiagnosticArray",)
"""Types of recorded topics that do not carry one message for each sampling instant."""


@cache
def sampled_topics() -> tuple[str, ...]:
    """Name the recorded topics that carry one message for each sampling instant, in the order of `topics.yaml`."""
    return tuple(name for name, row in load_topics().items() if row.recorded and row.type not in EVENT_TYPES)


@cache
def message_class(type_name: str) -> type:
    """Give the Python class of a message type, e.g. of "sensor_msgs/msg/JointState"."""
    package, _, name = type_name.split("/")
    found: type = getattr(import_module(f"{package}.msg"), name)
    return found


def qos_profile(profile: QosProfile) -> QoSProfile:
    """Translate a profile of `qos.yaml`."""
    return QoSProfile(
        history=HistoryPolicy[profile.history.upper()],
        depth=profile.depth,
        reliability=ReliabilityPolicy[profile.reliability.upper()],
        durability=DurabilityPolicy[profile.durability.upper()],
    )
