"""Logs of MuJoCo's position actuators, without torques, against the robot file of their MJCF."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

from flexros.effects.patching.patched_robot import load_model
from flexros.gap.checked_log import checked_log
from flexros.gap.measure_gap import MeasuredGap, measure_gap
from flexros.robot.exchange.mjcf.robot_import import robot_from_mjcf
from tests.program import program

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def script() -> ModuleType:
    return program("docs/results/programs/simulated/mujoco_servos.py")


def gap(script: ModuleType, folder: Path, **changed: tuple[float, ...]) -> MeasuredGap:
    base, file = folder / "nominal.xml", folder / "robot.yaml"
    base.write_text(script.ServoArm(script.NOMINAL).text)
    file.write_text(script.robot_text(robot_from_mjcf(base).text))
    model = mujoco.MjModel.from_xml_string(script.ServoArm({**script.NOMINAL, **changed}).text)
    wanted, known = script.command(1, 4.0), load_model(file)
    record = checked_log(script.log_of(wanted, script.run(model, wanted, 1)), known.robot, name="log")
    return measure_gap(record, known)


def test_imported_servos_predict_the_log_of_their_mjcf(script: ModuleType, tmp_path: Path) -> None:
    found = gap(script, tmp_path)
    assert not found.significant
    assert found.numbers.before < 1.0


def test_another_gain_is_a_gap(script: ModuleType, tmp_path: Path) -> None:
    found = gap(script, tmp_path, kp=(60.0, 90.0, 32.0))
    assert found.significant
    assert found.numbers.before > 3.0


def test_drawn_arms_differ_in_what_is_listed(script: ModuleType) -> None:
    arm, causes = script.drawn(3)
    numbers = {(name, joint) for name in arm.numbers for joint in range(3)}
    changed = [(name, joint) for name, joint in numbers if arm.numbers[name][joint] != script.NOMINAL[name][joint]]
    assert len(changed) == len(causes) == 5


@pytest.fixture(scope="module")
def six_axes() -> ModuleType:
    return program("docs/results/programs/simulated/mujoco_six_axis_servos.py")


def test_six_imported_servos_predict_the_log_of_their_mjcf(
    six_axes: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(six_axes, "DURATION", 6.0)
    known, signs = six_axes.nominal_model(tmp_path)
    log = six_axes.log_of(six_axes.arm(six_axes.NOMINAL), 0, 1, signs)
    assert not measure_gap(checked_log(log, known.robot, name="log"), known).significant


def test_drawn_six_axes_differ_in_what_is_listed(six_axes: ModuleType) -> None:
    numbers, load, delay, truth = six_axes.drawn(2)
    changed = sum(a != b for name in numbers for a, b in zip(numbers[name], six_axes.NOMINAL[name], strict=True))
    assert (changed, len(truth)) == (9, 9 + (load > 0) + (delay > 0))
    assert truth["delay", "all"] == pytest.approx(delay / six_axes.RATE)
    assert six_axes.arm(numbers, load).body("load").mass == pytest.approx(truth["tool_load", "tool"])
