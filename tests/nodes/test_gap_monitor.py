"""Gap monitor node: figures on /diagnostics from received messages equal those of the log."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from sensor_msgs.msg import JointState

from flexros.effects.patching.patched_robot import load_model
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.logs.write_log import write_log
from flexros.monitor.gap_monitor import GapMonitor
from flexros.monitor.statement import robot_sentence
from flexros.monitor.watch_log import watch_log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from flexros_nodes.gap_monitor import GapMonitorNode
from flexros_nodes.protocol.parameters import node_parameters

pytestmark = pytest.mark.slow

Bench = Any  # the class is in conftest
AT_ONCE = 500
SECONDS = 6


@cache
def course(effect: str) -> Log:
    changes: dict[str, Any] = {"robot": "elbow", "diagnosis.length": 10, "seed": 31}
    if effect:
        changes["plant.effects"] = [effect]
    log = closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(changes, "test")))
    end, commands = int(log.joint_states.stamp[0]) + SECONDS * 10**9, log.joint_commands
    assert commands is not None
    return replace(log, joint_states=log.joint_states.until(end), joint_commands=commands.until(end))


class Robot:
    """Publishes states and commands of a log, in another order of the joints."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.node = bench.hold(Node("robot", context=bench.context))
        self.states, self.commands = (
            self.node.create_publisher(JointState, name, 2000) for name in ("joint_states", "joint_commands")
        )
        self.heard: list[DiagnosticArray] = []
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self.heard.append, 10)

    def play(self, log: Log, monitor: Any, n: int = 10**9) -> None:
        self.bench.spin_until(lambda: self.states.get_subscription_count() and self.commands.get_subscription_count())
        names = log.joint_states.names[::-1]
        state, command = JointStateTemplate(names, position=True), JointStateTemplate(names, effort=True)
        position, commands = log.joint_states.position, log.joint_commands
        assert position is not None
        assert commands is not None
        assert commands.effort is not None
        n = min(n, len(position))
        for first in range(0, n, AT_ONCE):
            for k in range(first, min(first + AT_ONCE, n)):
                stamp = int(log.joint_states.stamp[k])
                self.states.publish(state.fill(stamp, position=position[k, ::-1]))
                self.commands.publish(command.fill(stamp, effort=commands.effort[k, ::-1]))
            done = min(first + AT_ONCE, n)
            self.bench.spin_until(lambda done=done: monitor.figures()["commands"] >= done)


def watching(bench: Bench, **values: Any) -> Any:
    node = bench.add(GapMonitorNode, **{"model": "elbow", "period": 0.1, "max_load": 1.0, **values})
    node.tells_errors = False
    node.trigger_configure()
    node.trigger_activate()
    return node


def test_parameters_are_described_with_their_bounds() -> None:
    for name, specification in node_parameters("gap_monitor").items():
        assert specification.description.endswith("."), name
        assert specification.type not in ("int", "double") or specification.bounds is not None, name


@pytest.mark.parametrize("effect", ["", "coulomb_friction@motor_2:level=1"])
def test_figures_are_bit_equal_to_those_of_the_log(bench: Bench, tmp_path: Path, effect: str) -> None:
    log = course(effect)
    node, robot = watching(bench), Robot(bench)
    robot.play(log, node)
    write_log(log, tmp_path / "log")
    monitor = GapMonitor(load_model("elbow"))
    watch_log(read_log(tmp_path / "log"), monitor, name="log")
    expected, found = monitor.reading(), node.monitor.reading()
    assert [vars(motor) for motor in found.motors] == [vars(motor) for motor in expected.motors]
    assert robot_sentence(found) == robot_sentence(expected)
    assert (node.monitor.alarms > 0) is bool(effect)
    assert vars(node.monitor.counts) == vars(monitor.counts)
    for one, other in zip(found.locations, expected.locations, strict=True):
        assert one.location.words == other.location.words
        np.testing.assert_array_equal(one.lines, other.lines)


def test_diagnostics_name_robot_and_motors(bench: Bench) -> None:
    node, robot = watching(bench), Robot(bench)
    robot.play(course("coulomb_friction@motor_2:level=1"), node)
    robot.heard.clear()
    bench.spin_until(lambda: len(robot.heard) > 1)
    statuses = {status.name: status for status in robot.heard[-1].status}
    assert list(statuses) == ["/gap_monitor", "/gap_monitor: motor_1", "/gap_monitor: motor_2"]
    whole, motor = statuses["/gap_monitor"], statuses["/gap_monitor: motor_2"]
    assert whole.level == motor.level == DiagnosticStatus.ERROR
    assert whole.hardware_id == "elbow"
    assert whole.message.startswith("alarm since ")
    assert "motor_2" in whole.message
    values = {pair.key: pair.value for pair in motor.values}
    assert float(values["share_of_alarm"]) > 1
    assert 0.5 < float(values["missing_torque_rms"]) < 1.5
    assert float(values["missing_torque_floor"]) < 0.1
    of_robot = {pair.key: pair.value for pair in whole.values}
    assert of_robot["joint"] == "motor_2"
    assert 0.5 < float(of_robot["seen"]) <= 1.0
    assert float(of_robot["processor_time_s"]) > 0
    stamp = robot.heard[-1].header.stamp
    assert stamp.sec + 1e-9 * stamp.nanosec == pytest.approx(node.monitor.reading().stamp * 1e-9)


def test_silent_topics_are_reported(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros_nodes.gap_monitor.SILENCE", 0.2)
    watching(bench)
    robot = Robot(bench)
    bench.spin_until(lambda: any("no messages on" in array.status[0].message for array in robot.heard))
    status = robot.heard[-1].status[0]
    assert status.level == DiagnosticStatus.WARN
    assert "no messages on joint_states and joint_commands" in status.message


def test_messages_that_are_none_of_this_robot_are_counted(bench: Bench) -> None:
    node, robot = watching(bench), Robot(bench)
    robot.play(course(""), node, 1000)
    robot.states.publish(JointState(name=["left", "right", "other"], position=[1.0, 2.0, 3.0]))
    robot.commands.publish(JointState(name=["motor_1", "motor_2"]))
    bench.spin_until(lambda: node.figures()["unusable_messages"] == 2)
    assert node.report is None
    bench.spin_until(lambda: any("joint_commands has no effort" in array.status[0].message for array in robot.heard))


def test_without_processor_time_messages_are_skipped_and_counted(bench: Bench) -> None:
    node, robot = watching(bench), Robot(bench)
    node.budget.use(1e9)
    robot.bench.spin_until(lambda: robot.states.get_subscription_count() > 0)
    robot.states.publish(JointState(name=["motor_1", "motor_2"], position=[1.0, 2.0]))
    bench.spin_until(lambda: node.figures()["passed_over"] == 1)
    assert node.figures()["states"] == 0


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"model": ""}, "parameter model of node gap_monitor is empty; give a robot, by name or file, or a patch"),
        ({"model": "elbo"}, "elbo"),
        ({"thresholds": "none.json"}, "the calibration none.json cannot be read"),
    ],
)
def test_invalid_model_is_rejected(bench: Bench, values: dict[str, str], told: str) -> None:
    node = bench.add(GapMonitorNode, **{"model": "elbow", **values})
    node.tells_errors = False
    node.trigger_configure()
    assert node.report.exit_code == 2
    assert told in node.report.message
