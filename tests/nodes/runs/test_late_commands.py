"""Plant in real time with late commands, or with many foreign ones."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy

from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.stamps import stamp_ns
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.shell.topic_interface import message_class, qos_profile, topic
from tests.nodes.conftest import Bench
from tests.nodes.loop_on_bench import hear

T = 5e-4
PATIENCE = 10
"""Samples for which a command is held."""


class Partner:
    """Sends commands to a plant in real time whose cycles are started by hand, so that no machine is too slow."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.plant = bench.add(PlantNode, observers=0, real_time=True, real_time_patience=PATIENCE * T)
        node = bench.hold(rclpy.create_node("partner", context=bench.context))
        for name in ("joint_states", "tool_pose"):
            hear(node, name)
        row = topic("joint_commands")
        self._publisher = node.create_publisher(message_class(row.type), row.name, qos_profile(row.qos))
        self._command = JointStateTemplate(("motor_1", "motor_2"), effort=True)
        self.plant.trigger_configure()
        self.plant.trigger_activate()
        bench.spin_until(lambda: self.loop.sample == 0)
        self.pacing = self.plant.paced
        bench.spin_until(self._begun)

    @property
    def loop(self):  # type: ignore[no-untyped-def]
        return self.plant.loop

    def _begun(self) -> bool:
        self.send(0)
        return self.pacing.schedule is not None

    def send(self, sample: int, torque: float = 0.0) -> None:
        self._publisher.publish(self._command.fill(stamp_ns(sample, T), effort=[torque, 0.0]))

    def hear(self, messages: int) -> None:
        """Spin until the plant has received as many messages that do not answer the present sample."""
        heard = self.loop.lockstep.stale
        self.bench.spin_until(lambda: self.pacing.answered() or self.loop.lockstep.stale >= heard + messages)

    def cycle(self) -> None:
        self.pacing.schedule.started(self.pacing.schedule.due)
        self.pacing.cycle()


def test_partner_that_answers_late_is_not_gone(bench: Bench) -> None:
    partner = Partner(bench)
    partner.cycle()
    for sample in range(1, 4 * PATIENCE):
        partner.cycle()
        partner.send(sample, torque=1.0)
        partner.hear(1)
    assert partner.plant.report is None
    assert partner.loop.sample == 4 * PATIENCE
    assert partner.plant.figures()["missed_commands"] >= 4 * PATIENCE - 1
    assert np.abs(partner.loop.plant.measure()).max() > 0.0


def test_silent_partner_counts_as_gone(bench: Bench) -> None:
    partner = Partner(bench)
    for _ in range(PATIENCE + 2):
        partner.cycle()
    bench.spin_until(lambda: partner.plant.report is not None)
    assert "the controller is gone or lacks its reference" in partner.plant.report.message


def test_command_is_found_among_messages_of_others(bench: Bench) -> None:
    partner = Partner(bench)
    partner.cycle()
    for sample in range(1, 2 * PATIENCE):
        for other in range(20):
            partner.send(10**6 + other)
        partner.send(sample, torque=1.0)
        partner.hear(20)
        assert partner.pacing.answered()
        partner.cycle()
    assert partner.plant.figures()["missed_commands"] == 0
