"""Positions that begin again: joints that turn on, encoders that are reset, and fast motion."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.logs.time_series import JointSeries, Log
from flexros.logs.wrapped_positions import joined, with_joined_positions, wrap_period

TIME = np.arange(0.0, 60.0, 0.02)


def turning(amplitude: float = 40.0) -> FloatArray:
    """A joint that turns to and fro, and stands still at the end."""
    return amplitude * np.sin(0.2 * np.minimum(TIME, 50.0)) + 0.3 * np.sin(5 * TIME)


def wrapped(whole: FloatArray, period: float) -> FloatArray:
    return np.asarray((whole + period / 2) % period - period / 2)


@pytest.mark.parametrize("period", [2 * np.pi, 25.0, 360.0, 32.768])
def test_the_range_is_found_and_joined(period: float) -> None:
    whole = turning(3 * period)
    values = wrapped(whole, period)
    found = wrap_period(values)
    assert found == pytest.approx(period, rel=0.02)
    np.testing.assert_allclose(joined(values, period), whole, atol=1e-9)


def test_values_that_are_missing_stay() -> None:
    values = wrapped(turning(), 25.0)
    values[100:104] = np.nan
    assert wrap_period(values) == 25.0
    np.testing.assert_array_equal(np.isnan(joined(values, 25.0)), np.isnan(values))


def test_one_step_is_a_turn_or_a_reset() -> None:
    whole = np.linspace(-2.0, 5.0, 500)
    assert wrap_period(wrapped(whole, 2 * np.pi)) == 2 * np.pi
    assert wrap_period(whole - 4.0 * (whole > 1.0)) is None


@pytest.mark.parametrize("step", [0.5, 30.0])
def test_motion_to_and_fro_does_not_begin_again(step: float) -> None:
    """Nor do an encoder of a few steps or that toggles between two, a joint at rest, and one that is thrown about."""
    assert wrap_period(step * np.rint(turning(2.0) / step)) is None
    assert wrap_period(np.zeros(100)) is None
    assert wrap_period(step * (np.arange(1000) // 100 % 2)) is None
    assert wrap_period(np.random.default_rng(1).standard_normal(1000)) is None


def test_what_was_commanded_is_joined_in_the_same_turn() -> None:
    stamp, names = np.arange(len(TIME)) * 20_000_000, ("a", "b")
    whole = np.stack([turning(), 0.1 * turning()], axis=-1)
    position = np.stack([wrapped(whole[:, 0], 2 * np.pi), whole[:, 1]], axis=-1)
    later = np.stack([wrapped(whole[:, 0] + 0.05, 2 * np.pi), whole[:, 1]], axis=-1)[700:]
    states, commands = JointSeries(stamp, names, position), JointSeries(stamp[700:], names, later)
    warnings: list[str] = []
    log = with_joined_positions(Log(states, commands), warnings)
    assert log.joint_states.position is not None
    assert log.joint_commands is not None
    assert log.joint_commands.position is not None
    np.testing.assert_allclose(log.joint_states.position, whole, atol=1e-9)
    np.testing.assert_allclose(log.joint_commands.position[:, 0], whole[700:, 0] + 0.05, atol=1e-9)
    assert len(warnings) == 1
    assert "a begin again after 6.283" in warnings[0]
