from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.analysis import analyse
from flexros.analysis.torque_limits import limited_drives
from flexros.analysis.tracking import Drive
from flexros.errors import InputError
from flexros.robot import load_robot

DRIVES = (Drive("motor_1", 100.0), Drive("motor_2", np.inf))
JOINTS = ("motor_1", "motor_2")


def with_limit(limit):
    return {"scenario": {"name": "moves", "controller": {"torque_limit": limit}}}


def limits(*arguments):
    warnings = []
    drives = limited_drives(*arguments, warnings)
    assert warnings == []
    return {joint: (drive.torque_limit, drive.limited_by) for joint, drive in drives.items()}


def test_the_smaller_of_both_limits_holds():
    assert limits(DRIVES, JOINTS, with_limit(200.0)) == {
        "motor_1": (100.0, "robot"),
        "motor_2": (200.0, "controller.torque_limit"),
    }
    assert limits(DRIVES, JOINTS, with_limit([50.0, 300.0])) == {
        "motor_1": (50.0, "controller.torque_limit"),
        "motor_2": (300.0, "controller.torque_limit"),
    }


@pytest.mark.parametrize("provenance", [{}, with_limit(None), {"scenario": "circle_pd"}, {"scenario": {}}])
def test_without_a_limit_of_the_controller_that_of_the_robot_holds(provenance):
    assert limits(DRIVES, JOINTS, provenance) == {"motor_1": (100.0, "robot"), "motor_2": (np.inf, "robot")}
    assert limited_drives(None, JOINTS, provenance, []) is None


def test_the_limit_of_the_controller_is_used_without_a_robot():
    drives = limits(None, ("a", "b"), with_limit([5.0, 6.0]))
    assert drives == {"a": (5.0, "controller.torque_limit"), "b": (6.0, "controller.torque_limit")}


def test_limits_of_the_controller_follow_the_names_of_the_joints():
    drives = limits(DRIVES, ("motor_2", "motor_1"), with_limit([50.0, 300.0]))
    assert {joint: limit for joint, (limit, _) in drives.items()} == {"motor_2": 300.0, "motor_1": 50.0}


@pytest.mark.parametrize("limit", ["much", [1.0, 2.0, 3.0], -5.0, float("nan"), [[1.0, 2.0]], {"a": 1}])
def test_a_limit_that_is_none_is_left_out_with_a_sentence(limit):
    warnings = []
    drives = limited_drives(DRIVES, JOINTS, with_limit(limit), warnings)
    assert {joint: drive.torque_limit for joint, drive in drives.items()} == {"motor_1": 100.0, "motor_2": np.inf}
    assert warnings == [
        f"controller.torque_limit in the provenance is {limit!r}, allowed is a positive number or one for each of the "
        "motors (2); it was ignored"
    ]


def test_another_number_of_motors_is_refused_all_the_same():
    with pytest.raises(InputError, match="the robot has 2 motors and the log has 1 joint"):
        limited_drives(DRIVES, ("motor_1",), with_limit(1.0), [])


def limited(log, limit):
    """The run of the log with its command cut at a limit of the controller."""
    command = replace(log.joint_commands, effort=np.clip(log.joint_commands.effort, -limit, limit))
    return replace(log, joint_commands=command, provenance=with_limit(limit))


def test_a_command_at_its_limit_and_a_feedforward_beyond_it_are_warned_of(make_run):
    log = limited(make_run(feedback=0.0), 2000.0)
    analysis = analyse(log, robot=load_robot("e12"))
    ahead = np.abs(log.joint_reference.effort[:, 1])
    motor = analysis.motors[1]
    assert motor.saturated_share == pytest.approx(np.mean(ahead >= 2000.0))
    share = f"{1e2 * np.mean(ahead > 2000.0):.3g} % of the run"
    warnings_of_motor = [warning for warning in analysis.warnings if "motor_2" in warning]
    assert warnings_of_motor == [
        f"the command of motor_2 is at its limit of 2000 Nm (controller.torque_limit) for {share}, where no feedback "
        "can act",
        f"the feedforward torque of motor_2 alone exceeds the limit of 2000 Nm (controller.torque_limit) for {share} "
        "(up to 3700 Nm): the motor cannot follow this motion; slow it down or raise the limit",
    ]
    assert not any("motor_1" in warning for warning in analysis.warnings), "it needs 1250 Nm"


def test_a_limit_that_is_touched_for_a_moment_is_not_warned_of(make_run):
    """Feedback alone reaches it, in less than one percent of the run."""
    log = make_run(feedback=0.0)
    effort = log.joint_commands.effort.copy()
    effort[100:109, 0] = 5000.0
    log = limited(replace(log, joint_commands=replace(log.joint_commands, effort=effort)), 4000.0)
    analysis = analyse(log)
    assert analysis.motors[0].saturated_share == pytest.approx(9 / 1001)
    assert analysis.warnings == ()


def test_the_limit_stands_among_the_figures(make_run):
    motor = analyse(limited(make_run(), 2000.0)).as_dict()["motors"]["motor_2"]
    assert motor["torque_limit"] == 2000.0
    assert motor["torque_limited_by"] == "controller.torque_limit"
    assert motor["overload_share"] > 0.1
