"""A controller that the machine has kept waiting, while a plant in real time went on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.stamps import START_NS, stamp_of

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy

from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.shell.topic_interface import message_class, qos_profile, topic
from tests.nodes.loop_on_bench import hear

NAMES = ("motor_1", "motor_2")
SAMPLE_NS = 500_000
SAMPLES = 200
"""Those of 0.1 s, after which a plant takes its controller for gone."""

Bench = Any  # the class is in conftest


@pytest.mark.slow
def test_every_measurement_of_a_tenth_of_a_second_is_answered(bench: Bench, short_scenario: Path) -> None:
    common = {"scenario": str(short_scenario), "observers": 0}
    controller, _ = nodes = [bench.add(kind, **common) for kind in (ControllerNode, FeedforwardNode)]
    plant = bench.hold(rclpy.create_node("plant", context=bench.context))
    commands = hear(plant, "joint_commands")
    row = topic("joint_states")
    states = plant.create_publisher(message_class(row.type), row.name, qos_profile(row.qos))
    clock = topic("clock")
    plant.create_publisher(message_class(clock.type), clock.name, qos_profile(clock.qos))
    for node in nodes:
        node.trigger_configure()
        node.trigger_activate()
    bench.spin_until(lambda: states.get_subscription_count() > 0 and controller.find_partners())
    bench.spin_until(lambda: len(controller.buffer) >= SAMPLES)

    message = JointStateTemplate(NAMES, position=True)
    for k in range(SAMPLES):  # nothing spins meanwhile
        states.publish(message.fill(START_NS + k * SAMPLE_NS, [0.0, 0.0]))

    bench.spin_until(lambda: len(commands) == SAMPLES)
    assert [stamp_of(one) for one in commands] == [START_NS + k * SAMPLE_NS for k in range(SAMPLES)]
