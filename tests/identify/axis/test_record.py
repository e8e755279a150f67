"""What is taken from a log, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.axis.record import axis_record
from flexros.logs.time_series import JointSeries, Log


def log(n: int = 300, first_command: int = 0) -> Log:
    stamp = 1_000_000_000 + 2_000_000 * np.arange(n)
    u, y = np.arange(n, dtype=float)[:, None], 0.5 * np.arange(n, dtype=float)[:, None]
    return Log(
        JointSeries(stamp, ("motor_1",), position=y),
        JointSeries(stamp[first_command:], ("motor_1",), effort=u[first_command:]),
    )


def test_signals_of_a_log() -> None:
    record = axis_record(log(), "motor_1", "position", 0.0, "it")
    assert record.sample_time == pytest.approx(2e-3)
    np.testing.assert_array_equal(record.inputs()[:3], [[0.0, 0.0], [1.0, 0.5], [2.0, 1.0]])
    np.testing.assert_allclose(record.speed, 250.0)
    assert record.rms_speed == pytest.approx(250.0)


def test_delayed_commands_act_in_parts_of_a_sample() -> None:
    record = axis_record(log(), "motor_1", "position", 0.005, "it")
    assert record.durations == pytest.approx((1e-3, 1e-3))
    np.testing.assert_array_equal(record.inputs()[10], [7.0, 8.0, 5.0])


def test_rows_before_the_first_command_are_left_out() -> None:
    record = axis_record(log(first_command=20), "motor_1", "position", 0.0, "it")
    assert len(record.torque) == 280
    assert (record.torque[0], record.output[0]) == (20.0, 10.0)


def test_speed_as_output_gives_the_position_by_its_sum() -> None:
    given = log()
    states = replace(given.joint_states, velocity=np.ones((300, 1)))
    record = axis_record(replace(given, joint_states=states), "motor_1", "velocity", 0.0, "it")
    np.testing.assert_allclose(record.position, 2e-3 * np.arange(1, 301))
    np.testing.assert_array_equal(record.speed, 1.0)


def gap(given: Log) -> Log:
    stamp = given.joint_states.stamp.copy()
    stamp[100:] += 2_000_000
    return replace(given, joint_states=replace(given.joint_states, stamp=stamp))


def infinite(given: Log) -> Log:
    position = given.joint_states.position.copy()  # type: ignore[union-attr]
    position[7] = np.nan
    return replace(given, joint_states=replace(given.joint_states, position=position))


@pytest.mark.parametrize(
    ("given", "joint", "message"),
    [
        (log(), "motor_2", r"unknown joint 'motor_2' in it: joint_states"),
        (log(100), "motor_1", r"it has 100 samples with a command, needed are 200; give a longer log"),
        (replace(log(), joint_commands=None), "motor_1", r"it has no commanded torque \(effort of joint_commands\)"),
        (gap(log()), "motor_1", r"it: the interval at 0\.198 s is 4 ms instead of .* without gaps"),
        (infinite(log()), "motor_1", r"it: position of motor_1 is not finite in sample 7; cut the log there"),
    ],
)
def test_what_a_log_lacks_is_named(given: Log, joint: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        axis_record(given, joint, "position", 0.0, "it")


def test_speed_that_was_not_recorded_is_named() -> None:
    with pytest.raises(InputError, match="joint_states has no velocity, which is to be predicted; record it"):
        axis_record(log(), "motor_1", "velocity", 0.0, "it")
