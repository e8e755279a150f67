"""Which signals of a bag hold which quantity, by the forms of the usual messages."""

from __future__ import annotations

import re
from collections import defaultdict
from typing import TYPE_CHECKING

from flexros.errors import InputError
from flexros.record.proposal.found_signals import FoundSignals

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

_NAMED = re.compile(r"^(?P<topic>/.*?)\.(?P<field>[a-z_.]+)\[(?P<joint>[^\[\]]+)\]$")
_DYNAMIC = re.compile(r"^(?P<topic>/.*?)\.interface_values\[(?P<joint>[^\[\]]+)\]\.values\[(?P<field>[a-z_]+)\]$")
"""Names of signals by `message_numbers`, of messages that name their joints."""

_STATE_FIELDS = ("position", "velocity", "effort")
_REFERENCE = {"positions": "reference_position", "velocities": "reference_velocity"}
_REFERENCES = ("reference", "desired")
"""Fields of JointTrajectoryControllerState, in present and former distributions."""


def bag_topics(names: Iterable[str], bag: str) -> FoundSignals:
    """Find states, commands and references among the signals of a bag.

    Args:
        names: Names of its signals, as `/joint_states.position[elbow]`.
        bag: The bag, for error messages.

    Raises:
        InputError: No topic has positions of named joints.
    """
    found: dict[str, dict[str, dict[str, str]]] = defaultdict(lambda: defaultdict(dict))
    topics = dict.fromkeys(name.split(".")[0] for name in names)
    for name in names:
        match = _DYNAMIC.match(name) or _NAMED.match(name)
        if match and not match["joint"].isdigit():
            found[match["topic"]][match["field"]][match["joint"]] = name
    moving = [topic for topic in found if found[topic].get("position")]
    measured = [topic for topic in moving if not _is_command(topic)]
    if not measured:
        raise InputError(
            f"{bag} has no topic with positions of named joints, as sensor_msgs/JointState has; its topics with "
            f"numbers are {', '.join(topics) or '(none)'}: record joint_states, or write a mapping file"
        )
    states = max(measured, key=lambda topic: _rank(topic, found[topic]))
    signals: dict[str, dict[str, str]] = {"position": dict(found[states]["position"])}
    for key, quantity in (("velocity", "velocity"), ("effort", "measured_torque")):
        if found[states].get(key):
            signals[quantity] = dict(found[states][key])
    used = {states}
    for topic in found:
        if topic != states and _is_command(topic) and found[topic].get("effort"):
            signals.setdefault("torque_command", dict(found[topic]["effort"]))
            used.add(topic)
        for label, quantity in _REFERENCE.items():
            for kind in _REFERENCES:
                if found[topic].get(f"{kind}.{label}") and quantity not in signals:
                    signals[quantity] = dict(found[topic][f"{kind}.{label}"])
                    used.add(topic)
    ignored = {topic: _why_left_out(topic, found, states) for topic in topics if topic not in used}
    return FoundSignals(states, signals, ignored)


def _is_command(topic: str) -> bool:
    return "command" in topic.rsplit("/", 1)[-1]


def _rank(topic: str, fields: Mapping[str, Mapping[str, str]]) -> tuple[int, bool, bool, int]:
    """Order topics of states: with more fields, named joint_states, not of a dynamic state, with more joints."""
    named = topic.rsplit("/", 1)[-1] == "joint_states"
    plain = "dynamic" not in topic
    return sum(bool(fields.get(key)) for key in _STATE_FIELDS), named, plain, len(fields["position"])


def _why_left_out(topic: str, found: Mapping[str, Mapping[str, Mapping[str, str]]], states: str) -> str:
    if topic not in found:
        return "its messages do not name their joints"
    if found[topic].get("position"):
        return f"{states} has the same quantities"
    return "not needed"
