from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexros.analysis import analyse
from flexros.logs.time_series import Log, PoseSeries
from flexros.robot import load_robot


def test_the_known_error_of_a_run_is_found(make_run):
    analysis = analyse(make_run(error=3e-4))
    angle_at_maximum = np.pi / 6
    assert analysis.path is not None
    assert analysis.path.path.maximum == pytest.approx(3e-4 * np.exp(-0.1 * angle_at_maximum), rel=2e-3)
    assert analysis.timing.exact
    assert analysis.warnings == ()


def test_label_is_the_scenario_unless_given(make_run):
    assert analyse(make_run(label="circle_dae")).label == "circle_dae"
    assert analyse(make_run(), label="nominal").label == "nominal"
    described = replace(make_run(), provenance={"scenario": {"name": "circle_pd", "robot": "e12"}})
    assert analyse(described).label == "circle_pd"
    assert analyse(replace(make_run(), provenance={})).label == "run"


def test_cycles_are_cut_and_counted(make_run):
    analysis = analyse(make_run(cycles=3))
    assert analysis.performance is not None
    assert analysis.performance.cycles == 3
    assert "repeatability is from 3 cycles; ISO 9283 requires 10" in analysis.warnings


@pytest.mark.parametrize("absent", ["tool_reference", "tool_pose"])
def test_without_a_tool_topic_only_the_motor_side_is_reported(make_run, absent):
    analysis = analyse(replace(make_run(), **{absent: None}))
    assert analysis.path is None
    assert analysis.motors[0].tracking is not None
    assert f"the log has no {absent}, so only the motor side of the error is evaluated" in analysis.warnings


def test_without_reference_and_commands_timing_remains(make_run):
    analysis = analyse(replace(make_run(), joint_reference=None, joint_commands=None))
    assert analysis.timing.topic("joint_states") is not None
    assert "the log has no joint_reference with positions, so motor tracking is not evaluated" in analysis.warnings
    assert "the log has no feedforward torque, so the share of the feedback is not evaluated" in analysis.warnings


def test_a_reference_too_coarse_for_the_error_is_warned_of(make_run):
    log = make_run(error=1e-5)
    reference = log.tool_reference
    ellipse = reference.position * np.array([1.0, 1.0, 1.2])
    coarse = PoseSeries(reference.stamp[::16], "base", ellipse[::16], reference.orientation[::16])
    pose = replace(log.tool_pose, position=log.tool_pose.position * np.array([1.0, 1.0, 1.2]))
    warnings = analyse(replace(log, tool_pose=pose, tool_reference=coarse)).warnings
    assert any("may deviate from the chords between its samples by" in warning for warning in warnings)


def test_a_tool_at_rest_has_an_error_but_no_performance(make_run):
    log = make_run()
    still = replace(log.tool_reference, position=np.repeat(log.tool_reference.position[:1], 1001, axis=0))
    analysis = analyse(replace(log, tool_reference=still))
    assert analysis.path is not None
    assert analysis.performance is None
    assert "the commanded tool position never moves, so path accuracy is not evaluated" in analysis.warnings


def test_a_robot_that_does_not_turn_its_tool_has_no_orientation_error(make_run):
    log = make_run()
    turned = Rotation.from_euler("y", np.linspace(0.1, 0.5, 1001)[:, None]).as_quat()
    log = replace(log, tool_reference=replace(log.tool_reference, orientation=turned))
    assert analyse(log).path.orientation is not None
    assert analyse(log, robot=load_robot("e12")).path.orientation is None


def test_components_that_the_robot_does_not_control_are_left_out(make_run):
    log = make_run()
    noisy = log.tool_pose.position + np.outer(np.sin(np.arange(1001.0)), [0.0, 1e-3, 0.0])
    log = replace(log, tool_pose=replace(log.tool_pose, position=noisy))
    assert analyse(log).path.axes == ("x", "y", "z")
    analysis = analyse(log, robot=load_robot("e12"))
    assert analysis.path.axes == ("x", "z")
    assert analysis.path.path.maximum == pytest.approx(analyse(make_run()).path.path.maximum, rel=1e-9)


def test_a_linear_drive_is_reported_from_a_turning_one(make_run):
    log = make_run()
    single = replace(log.joint_states, names=("motor_1",), position=log.joint_states.position[:, :1])
    (motor,) = analyse(Log(single), robot=load_robot("emps")).motors
    assert motor.linear
    assert not analyse(log, robot=load_robot("e12")).motors[0].linear


def test_json_holds_the_same_figures(make_run):
    analysis = analyse(make_run(cycles=2))
    written = json.loads(json.dumps(analysis.as_dict(), allow_nan=False))
    assert written["path"]["path_error_m"]["max"] == analysis.path.path.maximum
    assert written["performance"]["RT_p_m"] == analysis.performance.position_repeatability
    assert written["motors"]["motor_2"]["feedback_share"] == analysis.motors[1].feedback_share
    assert written["timing"]["topics"]["joint_states"]["count"] == len(analysis.path.run.time)
    assert written["provenance"]["robot"]["name"] == "e12"


def test_torque_limits_follow_the_names_of_the_joints(make_run):
    log, robot = make_run(), load_robot("elbow")
    swapped = replace(log.joint_states, names=("motor_2", "motor_1"), position=log.joint_states.position[:, ::-1])
    motors = analyse(replace(log, joint_states=swapped), robot=robot).motors
    assert {motor.joint: motor.torque_limit for motor in motors} == {"motor_2": 2000.0, "motor_1": 3000.0}


def test_a_tool_that_never_follows_its_path_is_analysed_all_the_same(make_run):
    log = make_run()
    away = replace(log.tool_pose, position=np.repeat(log.tool_pose.position[:1] + 1.0, 1001, axis=0))
    analysis = analyse(replace(log, tool_pose=away))
    assert analysis.path is not None
    assert analysis.path.path.maximum > 1.0
    assert analysis.performance is None
    (warning,) = analysis.warnings
    assert warning.startswith(
        "path accuracy was not evaluated: tool_pose crosses no plane normal to the commanded path"
    )


def test_a_path_followed_in_part_says_how_much(make_run):
    log = make_run()
    points = log.tool_pose.position.copy()
    points[500:] = points[500]
    analysis = analyse(replace(log, tool_pose=replace(log.tool_pose, position=points)))
    assert analysis.performance is not None
    assert 80 < analysis.performance.points < 120
    (warning,) = analysis.warnings
    assert f"crosses only {analysis.performance.points} of 200 planes" in warning


@pytest.mark.parametrize(("planned", "warned"), [(1001, False), (2000, True), (None, False), ("many", False)])
def test_a_log_that_ends_early_says_so(make_run, planned, warned):
    log = make_run()
    warnings = analyse(replace(log, provenance={**log.provenance, "n_samples": planned})).warnings
    warning = "the log has 1001 of the 2000 samples of its run, which was aborted or lost samples"
    assert warnings == ((warning,) if warned else ())
