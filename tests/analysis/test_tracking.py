from __future__ import annotations

import numpy as np
import pytest

from flexros.analysis.tracking import Drive, assign_drives, motor_tracking
from flexros.errors import InputError
from flexros.logs.time_series import JointSeries, Log

START = 1_000_000_000


def series(n=1000, period=500_000, names=("motor_1",), **signals):
    return JointSeries(START + np.arange(n, dtype=np.int64) * period, names, **signals)


def column(values):
    return np.asarray(values, dtype=np.float64).reshape(len(values), -1)


def test_tracking_error_is_reference_minus_measurement():
    position = np.linspace(0.0, 1.0, 1000)
    error = 1e-3 * np.sin(np.arange(1000) * 2 * np.pi / 100)
    log = Log(series(position=column(position - error)), joint_reference=series(position=column(position)))
    (motor,) = motor_tracking(log, START)
    np.testing.assert_allclose(motor.error, error, atol=1e-15)
    assert motor.tracking is not None
    assert motor.tracking.rms == pytest.approx(1e-3 / np.sqrt(2), rel=1e-3)


def test_reference_of_a_lower_rate_is_interpolated():
    position = np.linspace(0.0, 1.0, 993)
    log = Log(
        series(993, position=column(position - 2e-3)),
        joint_reference=series(125, 4_000_000, position=column(position[::8])),
    )
    (motor,) = motor_tracking(log, START)
    assert motor.tracking is not None
    assert motor.tracking.maximum == pytest.approx(2e-3, rel=1e-9)


def test_feedback_is_what_the_command_adds_to_the_feedforward():
    phase = np.arange(1000) * 2 * np.pi / 100
    ahead, added = 30.0 * np.sin(phase), 4.0 * np.cos(phase)
    log = Log(
        series(position=column(phase)),
        joint_commands=series(effort=column(ahead + added)),
        joint_reference=series(position=column(phase), effort=column(ahead)),
    )
    (motor,) = motor_tracking(log, START)
    np.testing.assert_allclose(motor.feedback, added, atol=1e-12)
    assert motor.feedback_share == pytest.approx(4.0 / np.hypot(30.0, 4.0), rel=1e-9)


def test_torque_without_feedforward_is_all_feedback():
    effort = np.sin(np.arange(100.0))
    zero = np.zeros(100)
    log = Log(
        series(100, position=column(zero)),
        joint_commands=series(100, effort=column(effort)),
        joint_reference=series(100, position=column(zero), effort=column(zero)),
    )
    assert motor_tracking(log, START)[0].feedback_share == pytest.approx(1.0)


def test_share_of_the_time_at_the_torque_limit():
    torque = np.clip(np.linspace(-10.0, 10.0, 1001), -8.0, 8.0)
    log = Log(series(1001, position=column(torque)), joint_commands=series(1001, effort=column(torque)))
    (motor,) = motor_tracking(log, START, {"motor_1": Drive("motor_1", 8.0)})
    assert motor.saturated_share == pytest.approx(np.mean(np.abs(torque) == 8.0))
    assert motor.limited_by == "robot"
    assert motor.overload_share is None, "there is no feedforward"
    (motor,) = motor_tracking(log, START, {"motor_1": Drive("motor_1", np.inf)})
    assert motor.saturated_share == 0.0
    assert motor.limited_by is None


def test_share_of_the_time_in_which_the_feedforward_is_beyond_the_limit():
    ahead = np.linspace(-10.0, 10.0, 1001)
    log = Log(
        series(1001, position=column(ahead)),
        joint_commands=series(1001, effort=column(np.clip(ahead, -8.0, 8.0))),
        joint_reference=series(1001, position=column(ahead), effort=column(ahead)),
    )
    (motor,) = motor_tracking(log, START, {"motor_1": Drive("motor_1", 8.0)})
    assert motor.overload_share == pytest.approx(np.mean(np.abs(ahead) > 8.0 + 1e-6))
    (motor,) = motor_tracking(log, START, {"motor_1": Drive("motor_1", 10.0)})
    assert motor.overload_share == 0.0, "a feedforward at the limit does not exceed it"


def test_joints_are_matched_by_name_and_not_by_order():
    both = np.column_stack([np.full(10, 1.0), np.full(10, 2.0)])
    log = Log(
        series(10, names=("motor_1", "motor_2"), position=both),
        joint_reference=series(10, names=("motor_2", "motor_1"), position=both[:, ::-1] + 0.5),
    )
    assert [motor.tracking and motor.tracking.maximum for motor in motor_tracking(log, START)] == [0.5, 0.5]


def test_a_log_with_positions_alone_gives_no_figures():
    (motor,) = motor_tracking(Log(series(10, position=np.zeros((10, 1)))), START)
    assert motor.tracking is None
    assert motor.torque_max is None


def test_a_robot_with_another_number_of_motors_is_refused():
    with pytest.raises(InputError, match=r"the robot has 2 motors and the log has 1 joint \(motor_1\)"):
        assign_drives([Drive("motor_1", 1.0), Drive("motor_2", 1.0)], ["motor_1"], [])
    with pytest.raises(InputError, match=r"the robot has 1 motor and the log has 2 joints \(motor_1, motor_2\)"):
        assign_drives([Drive("motor_1", 1.0)], ["motor_1", "motor_2"], [])


def test_drives_are_assigned_by_name():
    drives, warnings = [Drive("motor_1", 1.0), Drive("motor_2", 2.0)], []
    limits = {
        joint: drive.torque_limit for joint, drive in assign_drives(drives, ["motor_2", "motor_1"], warnings).items()
    }
    assert limits == {"motor_2": 2.0, "motor_1": 1.0}
    assert warnings == []


def test_drives_are_assigned_by_place_where_the_names_differ_and_that_is_said():
    drives, warnings = [Drive("motor_1", 1.0), Drive("motor_2", 2.0)], []
    limits = {
        joint: drive.torque_limit for joint, drive in assign_drives(drives, ["elbow", "motor_1"], warnings).items()
    }
    assert limits == {"elbow": 1.0, "motor_1": 2.0}
    assert warnings == [
        "the log names its joints elbow, motor_1 and the robot motor_1, motor_2, so torque limits were assigned in the "
        "order of the log"
    ]


def test_deflection_of_a_link_is_that_about_its_mean():
    position = np.linspace(0.0, 1.0, 1000)
    bent = 2e-3 * np.sin(np.arange(1000) * 2 * np.pi / 100)
    link = series(position=column(position + bent + 0.1))
    log = Log(series(position=column(position)), other_series={"link_states": link})
    (motor,) = motor_tracking(log, START)
    assert motor.deflection == pytest.approx(2e-3, rel=1e-6)
    assert motor.as_dict()["link_deflection_max"] == motor.deflection
    assert motor_tracking(Log(series(position=column(position))), START)[0].deflection is None
