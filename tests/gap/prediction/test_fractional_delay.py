"""Delays of fractions of a sample: exact motion of a mass at all frequencies, whole samples, constant torque."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.prediction.fractional_delay import delayed_commands, delayed_halves

STEP = 5e-4


def moved(pieces: list[tuple[float, float]]) -> tuple[float, float]:
    """Position and speed of a unit mass at rest after (torque, time) pieces."""
    position = speed = 0.0
    for torque, time in pieces:
        position += speed * time + 0.5 * torque * time**2
        speed += torque * time
    return position, speed


def along(pieces: list[list[tuple[float, float]]]) -> np.ndarray:
    """Position and speed of a unit mass from rest after every sample, given as (torque, time) pieces."""
    state, states = np.zeros(2), []
    for sample in pieces:
        x, v = moved(sample)
        time = sum(duration for _, duration in sample)
        state = np.array([state[0] + state[1] * time + x, state[1] + v])
        states.append(state)
    return np.array(states)


@pytest.mark.parametrize("samples", [0.05, 0.5, 1.0, 2.9])
def test_a_mass_moves_as_under_the_torque_that_is_truly_delayed(samples: float) -> None:
    torque = np.random.default_rng(3).normal(size=300)  # as full of noise as that of a controller
    whole = int(samples)
    fraction = samples - whole
    new, old = (torque[np.maximum(np.arange(300) - age, 0)] for age in (whole, whole + 1))
    truth = along([[(a, fraction * STEP), (b, (1 - fraction) * STEP)] for a, b in zip(old, new, strict=True)])
    halves = delayed_halves(torque[:, None], [samples]).reshape(-1, 2)
    np.testing.assert_allclose(along([[(a, STEP / 2), (b, STEP / 2)] for a, b in halves]), truth, rtol=0, atol=1e-15)


def test_whole_samples_shift() -> None:
    torque = np.random.default_rng(4).normal(size=(50, 1))
    np.testing.assert_array_equal(delayed_halves(torque, [3.0])[6::2], torque[:-3])
    np.testing.assert_array_equal(delayed_halves(torque, [3.0])[7::2], torque[:-3])
    np.testing.assert_array_equal(delayed_halves(torque, [0.0])[::2], torque)


def test_a_constant_torque_stays() -> None:
    np.testing.assert_allclose(delayed_halves(np.full((100, 1), 2.5), [1.7]), 2.5, rtol=1e-12)


def test_every_motor_has_its_own_delay() -> None:
    torque = np.random.default_rng(5).normal(size=(50, 2))
    result = delayed_halves(torque, [0.0, 0.4])
    np.testing.assert_array_equal(result[::2, 0], torque[:, 0])
    np.testing.assert_array_equal(result[:, 1:], delayed_halves(torque[:, 1:], [0.4]))


@pytest.mark.parametrize("samples", [0.3, 1.0, 2.6])
def test_slow_position_commands_are_late_by_the_delay(samples: float) -> None:
    t = np.arange(8000)
    commands = np.sin(2 * np.pi * t / 2000)[:, None]
    expected = np.sin(2 * np.pi * (t - samples) / 2000)
    np.testing.assert_allclose(delayed_commands(commands, samples, [0])[500:, 0], expected[500:], atol=1e-5)


def test_a_small_delay_of_a_position_command_acts_after_its_step_too() -> None:
    """The torque behind a step is at its limit for a while, where what acts within one sample is lost."""
    step = np.repeat([0.0, 1.0], 50)[:, None]
    assert np.abs(delayed_commands(step, 0.05, [0])[53:60] - 1.0).min() > 0.01
