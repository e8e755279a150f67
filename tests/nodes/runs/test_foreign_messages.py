"""Messages of foreign nodes: invalid ones are skipped, a second controller is reported."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest

from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.reader import read_log
from flexros.logs.stamps import stamp_of
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

from flexros_nodes.bringup import composed
from flexros_nodes.bringup.run import run_scenario
from flexros_nodes.controller.node import READ_BUDGET, READS_PER_SAMPLE, ControllerNode

pytestmark = pytest.mark.usefixtures("ros_domain")

NAMES = ("motor_1", "motor_2")
SMALLEST = 5e-324
HEADER = b"\x00\x01\x00\x00"


class GarbageBeside(ControllerNode):
    """Controller that publishes an invalid message with every answer."""

    def configure(self) -> None:
        super().configure()
        self._random = Random(1)
        self._trajectories = self.announce("joint_trajectory")
        self._beside = self.announce("joint_commands")

    def publish_reply(self, command: bytes, reference: bytes) -> None:
        for publisher in (self._beside, self._trajectories):
            publisher.publish(HEADER + self._random.randbytes(self._random.choice((0, 3, 16, 40, 200))))
        super().publish_reply(command, reference)


def test_garbage_changes_nothing_and_is_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, log_differences: Callable[[Log, Log], list[str]]
) -> None:
    monkeypatch.setitem(composed.NODE_CLASSES, "controller", GarbageBeside)
    summary = run_scenario("circle_dae", tmp_path / "log", parameters={"plant": {"recorder_window": 0}})
    assert summary.exit_code == 0, summary.message
    direct = closed_loop(Experiment.prepare(load_scenario("circle_dae")))
    log = read_log(tmp_path / "log")
    assert log_differences(direct, log) == []
    assert summary.reports["plant"].figures["unreadable_messages"] > 100
    assert summary.reports["recorder"].figures["unreadable_messages"] > 100
    looks = READ_BUDGET + READS_PER_SAMPLE * len(direct.joint_states.stamp)
    assert READ_BUDGET < summary.reports["controller"].figures["refused_trajectories"] <= looks


def test_smallest_numbers_are_torques_like_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Denormal numbers, which a filter that decays ends in, arrive as they are and stop nothing."""

    class Smallest(ControllerNode):
        def configure(self) -> None:
            super().configure()
            torques = JointStateTemplate(NAMES, effort=True)
            self._smallest = lambda stamp: torques.fill(stamp, effort=[SMALLEST, -3 * SMALLEST])

        def publish_reply(self, command: bytes, reference: bytes) -> None:
            super().publish_reply(self._smallest(stamp_of(command)), reference)

    monkeypatch.setitem(composed.NODE_CLASSES, "controller", Smallest)
    scenario = load_scenario("circle_dae").with_values({"duration": 0.2})
    summary = run_scenario(scenario, tmp_path / "log")
    assert summary.exit_code == 0, summary.message
    commands = read_log(tmp_path / "log").joint_commands
    assert commands is not None
    assert commands.effort is not None
    assert commands.effort.tolist() == [[SMALLEST, -3 * SMALLEST]] * len(commands.stamp)


@pytest.mark.parametrize("real_time", [False, True], ids=["lock-step", "real time"])
def test_second_controller_aborts_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, real_time: bool) -> None:
    class TwoInOne(ControllerNode):
        def configure(self) -> None:
            super().configure()
            self._second = self.announce("joint_commands")

        def publish_reply(self, command: bytes, reference: bytes) -> None:
            super().publish_reply(command, reference)
            if self._answered > 100:
                other = JointStateTemplate(NAMES, effort=True).fill(stamp_of(command), effort=[1.0, 2.0])
                self._second.publish(other)

    monkeypatch.setitem(composed.NODE_CLASSES, "controller", TwoInOne)
    scenario = load_scenario("circle_dae").with_values({"duration": 1.0})
    parameters = {"plant": {"brake_duration": 0.01}}
    summary = run_scenario(scenario, tmp_path / "log", real_time=real_time, parameters=parameters)
    assert summary.exit_code == 3
    assert re.match(
        r"two commands for stamp 1\.05\d\d s on joint_commands differ, and 2 nodes publish it: a plant accepts one "
        "controller; stop the other; the plant has braked to zero torque",
        summary.message,
    )
