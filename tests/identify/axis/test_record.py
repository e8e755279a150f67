"""Signals of one motor, and what is rejected."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.time_series import JointSeries, Log
from tests.identify.axis.recorded_axis import axis_of


def log(n: int = 300, first_command: int = 0) -> Log:
    stamp = 1_000_000_000 + 2_000_000 * np.arange(n)
    u, y = np.arange(n, dtype=float)[:, None], 0.5 * np.arange(n, dtype=float)[:, None]
    return Log(
        JointSeries(stamp, ("motor_1",), position=y),
        JointSeries(stamp[first_command:], ("motor_1",), effort=u[first_command:]),
    )


def test_signals_of_a_log() -> None:
    record = axis_of(log())
    assert record.sample_time == pytest.approx(2e-3)
    np.testing.assert_array_equal(record.inputs()[:3], [[0.0, 0.0], [1.0, 0.5], [2.0, 1.0]])
    np.testing.assert_allclose(record.speed, 250.0)
    assert record.rms_speed == pytest.approx(250.0)


def test_delayed_commands_act_in_parts_of_a_sample() -> None:
    record = axis_of(log(), delay=0.005)
    assert record.durations == pytest.approx((1e-3, 1e-3))
    np.testing.assert_array_equal(record.inputs()[10], [7.0, 8.0, 5.0])


def test_rows_before_the_first_command_are_left_out() -> None:
    record = axis_of(log(first_command=20))
    assert len(record.torque) == 280
    assert (record.torque[0], record.output[0]) == (20.0, 10.0)


def test_speed_as_output_gives_the_position_by_its_sum() -> None:
    given = log()
    states = replace(given.joint_states, velocity=np.ones((300, 1)))
    record = axis_of(replace(given, joint_states=states), "velocity")
    np.testing.assert_allclose(record.position, 2e-3 * np.arange(1, 301))
    np.testing.assert_array_equal(record.speed, 1.0)


def test_measured_torque_has_no_delay_before_it() -> None:
    given = log()
    measured = replace(given, joint_states=replace(given.joint_states, effort=np.ones((300, 1))), joint_commands=None)
    assert axis_of(measured, delay=0.005).delay == 0.0


def without_positions(given: Log, rows: slice) -> Log:
    position = np.array(given.joint_states.position)
    position[rows] = np.nan
    return replace(given, joint_states=replace(given.joint_states, position=position))


def test_missing_samples_are_bridged_and_do_not_count() -> None:
    record = axis_of(without_positions(log(), np.s_[100:103]))
    np.testing.assert_allclose(record.output, 0.5 * np.arange(300))
    assert np.flatnonzero(record.of_measured(np.ones(300)) == 0).tolist() == [100, 101, 102]
    assert record.of_measured(np.ones((300, 2))).sum() == 2 * 297
    assert any("3 of 300 samples are missing" in text for text in record.warnings)


def test_longest_stretch_without_a_long_hole_is_used() -> None:
    record = axis_of(without_positions(log(), np.s_[50:60]))
    np.testing.assert_array_equal(record.torque, np.arange(60, 300))
    assert any("240 from sample 60 on" in text for text in record.warnings)


@pytest.mark.parametrize("given", [log(100), without_positions(log(), np.s_[150:160])])
def test_few_samples_in_a_row_are_rejected(given: Log) -> None:
    with pytest.raises(InputError, match="it has 1[0-9]+ samples in a row .*, at least 200 are needed"):
        axis_of(given)


def test_speed_that_was_not_recorded_is_named() -> None:
    with pytest.raises(InputError, match="joint_states has no velocity of motor_1, which is to be predicted"):
        axis_of(log(), "velocity")


def test_a_joint_that_stands_still_is_refused() -> None:
    given = log()
    still = replace(given.joint_states, position=np.full((300, 1), 0.3))
    with pytest.raises(InputError, match="motor_1 stands still"):
        axis_of(replace(given, joint_states=still))
