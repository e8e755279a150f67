"""Topics and QoS of `msgs_config` as ROS 2 types and profiles, and QoS overrides by parameters."""

from __future__ import annotations

from functools import cache
from importlib import import_module

from rcl_interfaces.msg import SetParametersResult
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions

from flexros.config.topics import QosProfile, Topic, load_topics
from flexros.errors import InputError, unknown_name
from flexros.logs.messages.codec import codec_of
from flexros_nodes.shell.qos_overrides import override_problem


def topic(name: str) -> Topic:
    """Return a row of `topics.yaml` by its name without a leading slash.

    Raises:
        InputError: The topic is unknown.
    """
    topics = load_topics()
    if name not in topics:
        raise unknown_name("topic", name, topics, "msgs_config/topics.yaml")
    return topics[name]


def period(name: str) -> float:
    """Return the period of a topic that has a rate [s]."""
    return 1.0 / (topic(name).rate or 1.0)


@cache
def sampled_topics() -> tuple[str, ...]:
    """Return the recorded topics with one message per sampling instant of the loop, in the order of `topics.yaml`.

    Sensors beside the motor encoders may have any rate, or be missing.
    """
    rows = load_topics().items()
    return tuple(name for name, row in rows if row.recorded and not row.needs_sensor and codec_of(row.type).sampled)


@cache
def message_class(type_name: str) -> type:
    """Return the Python class of a message type, e.g. of "sensor_msgs/msg/JointState"."""
    package, _, name = type_name.split("/")
    message: type = getattr(import_module(f"{package}.msg"), name)
    return message


def qos_profile(profile: QosProfile) -> QoSProfile:
    """Convert a profile of `qos.yaml`."""
    return QoSProfile(
        history=HistoryPolicy[profile.history.upper()],
        depth=profile.depth,
        reliability=ReliabilityPolicy[profile.reliability.upper()],
        durability=DurabilityPolicy[profile.durability.upper()],
    )


def overriding_options(profile: QosProfile, origin: str, *, publisher: bool) -> QoSOverridingOptions:
    """Return options by which parameters such as `qos_overrides./<topic>.publisher.depth` may change a profile.

    Args:
        profile: Profile of `qos.yaml` for this end of the topic.
        origin: Topic and node, for error messages.
        publisher: Whether this end is a publisher.
    """

    def check(given: QoSProfile) -> SetParametersResult:
        problem = override_problem(
            profile,
            publisher,
            history=given.history.name.lower(),
            depth=given.depth,
            reliability=given.reliability.name.lower(),
            durability=given.durability.name.lower(),
        )
        if problem:
            raise InputError(f"{origin}: {problem}; correct or omit it")
        return SetParametersResult(successful=True)

    kinds = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY, QoSPolicyKind.DURABILITY)
    return QoSOverridingOptions(kinds, callback=check)
