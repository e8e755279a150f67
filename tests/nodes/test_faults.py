"""Runs that break off: a clear sentence, exit code 3, a plant at zero torque and a readable log."""

from __future__ import annotations

import re
import resource
from pathlib import Path

import numpy as np
import pytest

from flexros.config.scenario import load_scenario
from flexros.logs.joint_state_message import JointStateTemplate
from flexros.logs.reader import read_log
from flexros.logs.stamps import stamp_of

pytest.importorskip("rclpy", reason="needs ROS 2")

from flexros_nodes import composed
from flexros_nodes.controller import ControllerNode
from flexros_nodes.recorder import RecorderNode
from flexros_nodes.run import run_scenario

pytestmark = pytest.mark.usefixtures("ros_domain")

NAMES = ("motor_1", "motor_2")
LAST_GOOD = 99
BRAKED = 20
PLANT = {"partner_timeout": 0.3, "brake_duration": 0.01}


def bad_controller(bad_message: JointStateTemplate | None, effort: tuple[float, ...] = ()) -> type[ControllerNode]:
    """Make a controller that answers well up to a sample and badly, or not at all, from then on."""

    class BadController(ControllerNode):
        def _publish(self, command: bytes, reference: bytes) -> None:
            if self._answered <= LAST_GOOD + 1:
                super()._publish(command, reference)
            elif bad_message is not None:
                self._commands.publish(bad_message.fill(stamp_of(command), effort=effort))

    return BadController


@pytest.mark.parametrize(
    ("bad_message", "effort", "sentence"),
    [
        (
            JointStateTemplate(NAMES, effort=True),
            (1.0, float("nan")),
            r"its effort is \[1\.0, nan\]; needed is one finite",
        ),
        (JointStateTemplate(("motor_1",), effort=True), (1.0,), "a JointState lacks motor_2; it has motor_1; needed"),
        (
            JointStateTemplate(("motor_1", "wrist"), effort=True),
            (1.0, 1.0),
            "a JointState lacks motor_2; it has motor_1, wrist",
        ),
        (None, (), r"no command for sample 100 \(stamp 1\.0500 s\) within 0\.3 s although the state was sent again"),
    ],
    ids=["nan", "size", "name", "silence"],
)
def test_bad_command_breaks_the_run_off(
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
    assert summary.message.endswith("the plant has braked to zero torque, the log is readable up to there")
    log = read_log(tmp_path / "log")
    assert log.joint_commands is not None
    assert len(log.joint_states.stamp) == LAST_GOOD + 2 + BRAKED
    assert log.joint_commands.effort is not None
    good = log.joint_commands.stamp <= log.joint_states.stamp[LAST_GOOD]
    assert np.isfinite(log.joint_commands.effort[good]).all()


def test_controller_silent_from_the_start_is_told_after_its_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Silent(ControllerNode):
        def _publish(self, command: bytes, reference: bytes) -> None:
            pass

    monkeypatch.setitem(composed.NODE_CLASSES, "controller", Silent)
    summary = run_scenario("circle_dae", tmp_path / "log", parameters={"plant": {**PLANT, "start_timeout": 0.5}})
    assert summary.exit_code == 3
    assert "no command for sample 0 (stamp 1.0000 s) within 0.5 s" in summary.message


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


def test_folder_that_cannot_be_written_is_told_before_the_run(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    summary = run_scenario("circle_dae", tmp_path / "file" / "log")
    assert summary.exit_code == 3
    assert "cannot create the log folder" in summary.message
    assert "name a folder that can be written" in summary.message
    assert summary.samples == 0


def test_plant_without_partners_says_what_it_lacks(monkeypatch: pytest.MonkeyPatch) -> None:
    parameters = {"plant": {"start_timeout": 0.2, "observers": 3}}
    summary = run_scenario("circle_dae", None, parameters=parameters)
    assert summary.exit_code == 3
    assert (
        "no partners within 0.2 s: joint_states has 1 subscriptions, needed are a controller and 3 recorders"
        in summary.message
    )
