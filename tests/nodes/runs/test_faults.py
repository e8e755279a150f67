"""Aborted runs: message, exit code 3, a plant at zero torque and a valid log."""

from __future__ import annotations

import re
import resource
from pathlib import Path

import numpy as np
import pytest

from flexros.errors import RunError
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.reader import read_log
from flexros.logs.stamps import stamp_of
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

from flexros_nodes.bringup import composed
from flexros_nodes.bringup.run import run_scenario
from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.recorder import RecorderNode

pytestmark = pytest.mark.usefixtures("ros_domain")

NAMES = ("motor_1", "motor_2")
LAST_GOOD = 99
BRAKED = 20
PLANT = {"partner_timeout": 0.3, "brake_duration": 0.01}


def bad_controller(bad_message: JointStateTemplate | None, effort: tuple[float, ...] = ()) -> type[ControllerNode]:
    """Make a controller that answers well up to a sample and badly, or not at all, from then on."""

    class BadController(ControllerNode):
        def publish_reply(self, command: bytes, reference: bytes) -> None:
            if self._answered <= LAST_GOOD + 1:
                super().publish_reply(command, reference)
            elif bad_message is not None:
                self._commands.publish(bad_message.fill(stamp_of(command), effort=effort))

    return BadController


@pytest.mark.parametrize(
    ("bad_message", "effort", "sentence"),
    [
        (
            JointStateTemplate(NAMES, effort=True),
            (1.0, float("nan")),
            r"its effort is \[1\.0, nan\]; required is one finite",
        ),
        (JointStateTemplate(("motor_1",), effort=True), (1.0,), "a JointState lacks motor_2; it has motor_1; required"),
        (
            JointStateTemplate(("motor_1", "wrist"), effort=True),
            (1.0, 1.0),
            "a JointState lacks motor_2; it has motor_1, wrist",
        ),
        (None, (), r"no command for sample 100 \(stamp 1\.0500 s\) within 0\.3 s although the state was sent again"),
    ],
    ids=["nan", "size", "name", "silence"],
)
def test_bad_command_aborts_the_run(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    bad_message: JointStateTemplate | None,
    effort: tuple[float, ...],
    sentence: str,
) -> None:
    monkeypatch.setitem(composed.NODE_CLASSES, "controller", bad_controller(bad_message, effort))
    summary = run_scenario("circle_dae", tmp_path / "log", parameters={"plant": PLANT})
    assert summary.exit_code == 3
    assert re.search(sentence, summary.message), summary.message
    assert summary.message.endswith("the plant has braked to zero torque; the log is valid up to that point")
    log = read_log(tmp_path / "log")
    assert log.joint_commands is not None
    assert len(log.joint_states.stamp) == LAST_GOOD + 2 + BRAKED
    assert log.joint_commands.effort is not None
    good = log.joint_commands.stamp <= log.joint_states.stamp[LAST_GOOD]
    assert np.isfinite(log.joint_commands.effort[good]).all()


def test_controller_silent_from_the_start_is_reported_after_its_time_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Silent(ControllerNode):
        def publish_reply(self, command: bytes, reference: bytes) -> None:
            pass

    monkeypatch.setitem(composed.NODE_CLASSES, "controller", Silent)
    summary = run_scenario("circle_dae", tmp_path / "log", parameters={"plant": {**PLANT, "start_timeout": 0.5}})
    assert summary.exit_code == 3
    assert "no command for sample 0 (stamp 1.0000 s) within 0.5 s" in summary.message


def test_silent_controller_in_real_time_is_braked_soon(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(composed.NODE_CLASSES, "controller", bad_controller(None))
    scenario = load_scenario("circle_dae").with_values({"duration": 20.0})
    summary = run_scenario(scenario, tmp_path / "log", real_time=True, parameters={"plant": {"brake_duration": 0.01}})
    assert summary.exit_code == 3
    assert "within 0.1 s: the controller is gone" in summary.message
    assert "sent again" not in summary.message
    assert 200 <= summary.timing["missed_commands"] < 400
    assert summary.reports["plant"].figures["braked_samples"] == 20


def test_long_braking_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(composed.NODE_CLASSES, "controller", bad_controller(None))
    parameters = {"plant": {"partner_timeout": 0.1, "brake_duration": 2.0}}
    summary = run_scenario("circle_dae", tmp_path / "log", parameters=parameters)
    assert summary.reports["plant"].figures["braked_samples"] == 4000
    recorded = summary.reports["recorder"].figures
    assert recorded["joint_states.messages"] == LAST_GOOD + 2 + 4000
    assert recorded["joint_states.missing"] == recorded["tool_pose.missing"] == 0


def test_exit_of_the_controller_is_reported_to_the_plant_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    class Failing(ControllerNode):
        def publish_reply(self, command: bytes, reference: bytes) -> None:
            super().publish_reply(command, reference)
            if self._answered > LAST_GOOD:
                raise RunError("the controller has had enough")

    monkeypatch.setitem(composed.NODE_CLASSES, "controller", Failing)
    parameters = {"plant": {"partner_timeout": 3600.0, "brake_duration": 0.01}}
    summary = run_scenario("circle_dae", tmp_path / "log", parameters=parameters)
    assert re.fullmatch(
        r"the controller has had enough; a partner of the plant exited at sample \d+ \(stamp 1\.0\d+ s\); the plant "
        "has braked to zero torque; the log is valid up to that point",
        summary.message,
    )
    assert "has had enough" not in "".join(capfd.readouterr())


def test_full_disk_ends_the_run_with_a_readable_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)

    class OnSmallDisk(RecorderNode):
        def start(self) -> None:
            super().start()
            resource.setrlimit(resource.RLIMIT_FSIZE, (600_000, limits[1]))

    monkeypatch.setitem(composed.NODE_CLASSES, "recorder", OnSmallDisk)
    scenario = load_scenario("regulator_four_mass").with_values({"duration": 6.0})
    try:
        summary = run_scenario(scenario, tmp_path / "log")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert summary.exit_code == 3
    assert "cannot write the log" in summary.message
    assert "make space and run again" in summary.message
    log = read_log(tmp_path / "log")
    assert 100 < len(log.joint_states.stamp) < 12_001


def test_unwritable_folder_is_reported_before_the_run(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    summary = run_scenario("circle_dae", tmp_path / "file" / "log")
    assert summary.exit_code == 3
    assert "cannot create the log folder" in summary.message
    assert "name a folder that can be written" in summary.message
    assert summary.samples == 0
