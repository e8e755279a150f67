"""Kinematic identification from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from flexros.identify.kinematics.elastostatics import measured_points
from flexros.identify.kinematics.record import PoseRecord, poses_text, read_poses
from flexros.identify.kinematics.unknowns import unknowns
from flexros.robot import load_robot

pytestmark = pytest.mark.slow


def test_plan_then_fit(flexros, tmp_path: Path) -> None:
    robot = load_robot("elbow")
    plan = flexros(
        "identify",
        "kinematics",
        "--model",
        "elbow",
        "--plan",
        "30",
        "--load",
        "0",
        "--load",
        "60",
        "--out",
        str(tmp_path),
    )
    assert plan.code == 0, plan.err
    planned = read_poses(tmp_path / "poses.csv", robot)
    assert len(planned) == 30
    assert set(planned.load) == {0.0, 60.0}
    unknown = unknowns(robot)
    rng = np.random.default_rng(2)
    theta = rng.normal(size=len(unknown.names)) * unknown.deviation
    points, _ = measured_points(unknown, planned, theta)
    measured = PoseRecord(planned.motor_position, planned.load, points + 2e-5 * rng.normal(size=points.shape))
    (tmp_path / "measured.csv").write_text(poses_text(robot, measured))
    out = tmp_path / "found"
    fit = flexros(
        "identify", "kinematics", str(tmp_path / "measured.csv"), "--model", "elbow", "--out", str(out), "--json"
    )
    assert fit.code == 0, fit.err
    record = json.loads((out / "kinematics.json").read_text())
    assert record["fit"]["before"]["max_mm"] > 0.5
    assert record["fit"]["after"]["max_mm"] < 0.1
    assert load_robot(out / "robot.yaml").parameters["body_1.ry.zero"].value != 0.0


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((), "give either a CSV file"),
        (("--plan", "2"), "4 to all of them"),
        (("nowhere.csv",), "cannot be read"),
        (("--plan", "10", "--noise", "0"), "--noise is 0 m"),
    ],
)
def test_bad_input_ends_with_one_sentence(flexros, tmp_path: Path, arguments: tuple[str, ...], sentence: str) -> None:
    result = flexros("identify", "kinematics", *arguments, "--model", "elbow", "--out", str(tmp_path))
    assert result.code == 2
    assert sentence in result.err
