"""What the regression takes from a log."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.rigid.record import rigid_record
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log
from flexros.robot import Robot, load_robot

N = 200
STAMP = stamps_ns(N, 1e-3)
ONE = ("motor_1",)


def column(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(N, 1))


def make_log(**changes) -> Log:
    states = JointSeries(STAMP, ONE, position=column(1))
    return replace(Log(states, JointSeries(STAMP, ONE, effort=column(2))), **changes)


def test_measured_torque_goes_before_the_command(emps: Robot) -> None:
    log = make_log(joint_states=JointSeries(STAMP, ONE, position=column(1), effort=column(3)))
    assert rigid_record(log, emps, "log").measured
    np.testing.assert_array_equal(rigid_record(log, emps, "log").torque, column(3))


def test_command_of_the_same_sample(emps: Robot) -> None:
    record = rigid_record(make_log(), emps, "log")
    assert not record.measured
    assert record.sample_time == pytest.approx(1e-3)
    np.testing.assert_array_equal(record.torque, column(2))


def test_command_as_it_acts_is_the_mean_of_two_samples(emps: Robot) -> None:
    record = rigid_record(make_log(), emps, "log", hold=True)
    u = column(2)
    np.testing.assert_allclose(record.torque, (u[1:] + u[:-1]) / 2, atol=1e-9)
    np.testing.assert_array_equal(record.position, column(1)[1:])


def test_command_as_it_acts_is_delayed() -> None:
    robot = load_robot("four_mass_linear")
    stamp = stamps_ns(N, 5e-4)
    log = Log(JointSeries(stamp, ONE, position=column(1)), JointSeries(stamp, ONE, effort=column(2)))
    record = rigid_record(log, robot, "log", hold=True)
    u = column(2)
    np.testing.assert_allclose(record.torque, (u[1:-1] + u[:-2]) / 2, atol=1e-9)  # one sample of delay


def test_slower_commands_are_held(emps: Robot) -> None:
    slow = JointSeries(STAMP[10::4], ONE, effort=column(2)[10::4])
    record = rigid_record(make_log(joint_commands=slow), emps, "log")
    np.testing.assert_array_equal(record.torque[:8, 0], np.repeat(column(2)[[10, 14], 0], 4))
    assert len(record.torque) == N - 10


def test_joints_in_another_order() -> None:
    robot = load_robot("elbow")
    q = np.hstack([column(1), column(2)])
    series = JointSeries(STAMP, ("motor_2", "motor_1"), position=q, effort=q)
    np.testing.assert_array_equal(rigid_record(Log(series), robot, "log").position, q[:, ::-1])


def test_jitter_is_interpolated_and_told(emps: Robot) -> None:
    stamp = STAMP + np.random.default_rng(4).integers(-200_000, 200_000, N)
    q = (stamp - STAMP[0])[:, None] * 1e-9
    record = rigid_record(Log(JointSeries(stamp, ONE, position=q, effort=q)), emps, "log")
    assert "interpolated linearly" in record.warnings[0]
    np.testing.assert_allclose(np.diff(record.position[:, 0]), record.sample_time, rtol=1e-9)


def test_torque_at_its_limit_is_told(emps: Robot) -> None:
    effort = column(2)
    effort[5:9] = 351.506
    warnings = rigid_record(make_log(joint_commands=JointSeries(STAMP, ONE, effort=effort)), emps, "log").warnings
    assert warnings == (
        "the torque of motor_1 is at its limit of 351.506 in 4 samples; what is beyond the limit is not in the log",
    )


def lacks_position() -> Log:
    return make_log(joint_states=JointSeries(STAMP, ONE))


def lacks_torque() -> Log:
    return make_log(joint_commands=None)


def has_a_gap() -> Log:
    kept = np.r_[0:50, 53:N]
    states = JointSeries(STAMP[kept], ONE, position=column(1)[kept])
    return make_log(joint_states=states)


def has_nan() -> Log:
    q = column(1)
    q[7] = np.nan
    return make_log(joint_states=JointSeries(STAMP, ONE, position=q))


def other_joints() -> Log:
    return make_log(joint_states=JointSeries(STAMP, ("axis",), position=column(1)))


def late_commands() -> Log:
    return make_log(joint_commands=JointSeries(STAMP + 10**9, ONE, effort=column(2)))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lacks_position, "log: joint_states has no positions, which the regression needs; record them"),
        (lacks_torque, "log has neither measured torques (effort of joint_states) nor commanded ones"),
        (has_a_gap, "log: samples are missing at 0.049 s, where the interval is 4 ms instead of 1 ms (1 such places)"),
        (has_nan, "log: positions are not finite in 1 samples, first in sample 7; cut them out"),
        (other_joints, "log: joint_states has the joints axis, but robot emps has motor_1; give the robot of the log"),
        (late_commands, "log has 0 samples with a torque; give a longer log"),
    ],
)
def test_what_is_wrong_with_a_log_is_said(emps: Robot, make, message: str) -> None:
    with pytest.raises(InputError) as caught:
        rigid_record(make(), emps, "log")
    assert message in str(caught.value)
