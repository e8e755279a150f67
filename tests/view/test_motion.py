from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.effects.patching.patched_robot import load_model
from flexros.errors import InputError
from flexros.logs.reader import read_log
from flexros.view.motion import predicted_motion, robot_motion

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.logs.time_series import Log

MODEL = load_model("e12")


@pytest.fixture(scope="module")
def log(circle: Path) -> Log:
    return read_log(circle)


def test_estimated_arm_puts_the_tool_where_it_was(log: Log) -> None:
    motion = robot_motion(log, MODEL, "circle")
    rows = np.round(motion.time / MODEL.robot.sample_time).astype(int)
    assert log.tool_pose is not None
    tool = np.array([MODEL.robot.tool_pose(arm)[:3] for arm in motion.arm])
    stiff = np.array([MODEL.robot.tool_pose(arm)[:3] for arm in motion.stiff])
    true = log.tool_pose.position[rows]
    assert motion.bent
    assert np.abs(tool - true).max() < 2e-4
    assert np.abs(stiff - true).max() > 5e-2, "the springs of this robot bend by centimetres"


def test_without_torques_the_springs_are_drawn_stiff_and_the_note_says_why(log: Log) -> None:
    motion = robot_motion(replace(log, joint_commands=None), MODEL, "circle")
    assert not motion.bent
    np.testing.assert_array_equal(motion.arm, motion.stiff)
    assert "No deflection" in motion.note
    assert "torque" in motion.note


def test_part_of_a_log_is_shown(log: Log) -> None:
    motion = robot_motion(log, MODEL, "circle", 0.1, 0.2)
    assert motion.time[0] == pytest.approx(0.1)
    assert motion.time[-1] == pytest.approx(0.3, abs=0.006)


@pytest.mark.parametrize(("first", "length"), [(10.0, 1.0), (-1.0, 1.0), (0.0, 0.0)])
def test_part_outside_of_the_log_is_refused(log: Log, first: float, length: float) -> None:
    with pytest.raises(InputError, match="lasts 0.38"):
        robot_motion(log, MODEL, "circle", first, length)


def test_wrong_model_predicts_worse_than_the_right_one(log: Log) -> None:
    motion = robot_motion(log, MODEL, "circle")
    heavy = replace(MODEL, robot=MODEL.robot.with_values({"body_3.mass": 260.0}))
    right, wrong = (
        predicted_motion(log, model, motion, name=name, log_name="circle")
        for name, model in (("right", MODEL), ("wrong", heavy))
    )
    assert np.isnan(right.arm[0]).all(), "0.1 s ahead nothing is predicted yet"
    assert np.nanmax(np.abs(right.motor_error)) < 1e-4
    assert np.nanmax(np.abs(wrong.motor_error)) > 1e-3
    np.testing.assert_allclose(right.arm[-1], motion.arm[-1], atol=1e-4)
