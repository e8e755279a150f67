from __future__ import annotations

import numpy as np
import pytest

from flexros.compile.command_delay import split_delay
from flexros.errors import InputError
from flexros.feedforward.hold import held_torque, samples_ahead

T = 0.01


@pytest.mark.parametrize("delay", [0.0, 0.004, T, 1.25 * T, 3 * T])
def test_mean_of_a_linear_torque(delay: float) -> None:
    n, ahead = 5, samples_ahead(T, delay)
    time = np.arange(n + ahead) * T
    load = 3.0 + 7.0 * time[:, None]
    torque = held_torque(load, np.zeros_like(load), T, delay)
    expected = 3.0 + 7.0 * (time[:n] + delay + T / 2)
    np.testing.assert_allclose(torque[:, 0], expected, rtol=1e-12)


@pytest.mark.parametrize("delay", [0.0, 0.004, T])
def test_mean_of_an_acceleration_is_the_change_of_momentum(delay: float) -> None:
    n, ahead = 6, samples_ahead(T, delay)
    time = np.arange(n + ahead) * T
    momentum = 0.5 * 4.0 * time[:, None] ** 2  # acceleration torque 4 t, linear
    torque = held_torque(np.zeros_like(momentum), momentum, T, delay)
    expected = 4.0 * (time[:n] + delay + T / 2)
    np.testing.assert_allclose(torque[:, 0], expected, atol=0.02 * T * 4.0 * 13)


def test_impulse_is_kept_where_the_acceleration_jumps() -> None:
    time = np.arange(101) * T
    momentum = np.where(time < 0.503, 0.0, 8.0 * (time - 0.503))[:, None]  # jumps between two samples
    torque = held_torque(np.zeros_like(momentum), momentum, T, 0.0)
    assert T * torque.sum() == pytest.approx(momentum[-1, 0], rel=1e-12)


@pytest.mark.parametrize(("delay", "ahead"), [(0.0, 1), (0.004, 2), (T, 2), (1.2 * T, 3), (3 * T, 4)])
def test_samples_needed_ahead(delay: float, ahead: int) -> None:
    assert samples_ahead(T, delay) == ahead


def test_looks_exactly_as_far_ahead_as_the_loop_remembers_commands() -> None:
    for samples in (0.0, 5e-10, 2e-9, 0.3, 1.0 - 5e-10, 1.0, 2.7, 3.0):
        assert samples_ahead(T, samples * T) == split_delay(samples * T, T).line_length + 1


def test_impossible_delay_is_refused() -> None:
    with pytest.raises(InputError, match="command delay -0.001 s is not possible"):
        samples_ahead(T, -1e-3)
