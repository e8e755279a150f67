"""Signals of a bag by the forms of the usual messages."""

from __future__ import annotations

import pytest

from flexros.errors import InputError
from flexros.record.proposal.topics import bag_topics

STATES = [f"/joint_states.{field}[{joint}]" for field in ("position", "velocity", "effort") for joint in ("a", "b")]
DYNAMIC = [
    f"/dynamic_joint_states.interface_values[{joint}].values[{field}]"
    for joint in ("a", "b")
    for field in ("position", "effort")
]


def test_states() -> None:
    topics = bag_topics(STATES, "bag")
    assert topics.states == "/joint_states"
    assert topics.joints == ("a", "b")
    assert topics.signals["measured_torque"]["b"] == "/joint_states.effort[b]"


def test_plain_states_before_dynamic_ones() -> None:
    topics = bag_topics(DYNAMIC + STATES, "bag")
    assert topics.states == "/joint_states"
    assert "/dynamic_joint_states" in topics.ignored


def test_dynamic_states_alone() -> None:
    topics = bag_topics(DYNAMIC, "bag")
    assert topics.signals["measured_torque"]["a"] == "/dynamic_joint_states.interface_values[a].values[effort]"


@pytest.mark.parametrize("kind", ["reference", "desired"])
def test_reference_of_a_trajectory_controller(kind: str) -> None:
    topics = bag_topics([*STATES, f"/jtc/state.{kind}.positions[a]", f"/jtc/state.{kind}.positions[b]"], "bag")
    assert topics.signals["reference_position"]["b"] == f"/jtc/state.{kind}.positions[b]"


def test_commands_are_no_states() -> None:
    names = ["/joint_commands.position[a]", "/joint_commands.effort[a]", *STATES]
    topics = bag_topics(names, "bag")
    assert topics.states == "/joint_states"
    assert topics.signals["torque_command"] == {"a": "/joint_commands.effort[a]"}


def test_numbers_without_names_are_left_out() -> None:
    topics = bag_topics([*STATES, "/effort_controller/commands.data[0]"], "bag")
    assert topics.ignored == {"/effort_controller/commands": "its messages do not name their joints"}


def test_bag_without_joints_is_refused() -> None:
    with pytest.raises(InputError, match=r"/odom"):
        bag_topics(["/odom.pose.x"], "bag")
