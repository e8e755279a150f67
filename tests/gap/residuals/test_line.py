"""What acts at one frequency is found in prediction errors and taken out of them."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.gap.residuals.line import Line, line_in

T, N = 4e-3, 5000
TIME = T * np.arange(N)
FREQUENCY = 20.474


def noise() -> FloatArray:
    return np.random.default_rng(0).normal(size=(2, N))


def found(motors: FloatArray) -> Line | None:
    return line_in(motors, T, 2.0, 0.5, 0.125)


def of_line(frequency: float, amplitude: float = 20.0) -> FloatArray:
    """A wave whose amplitude and phase change with the pose, at one motor more than at the other."""
    slow = 1.0 + 0.3 * np.sin(2 * np.pi * 0.4 * TIME + 0.2)
    wave = amplitude * slow * np.sin(2 * np.pi * frequency * TIME + 0.5 * np.sin(2 * np.pi * 0.3 * TIME))
    return np.stack([wave, 0.1 * wave])


def test_a_line_is_found_and_leaves_no_more_than_noise() -> None:
    motors = noise() + of_line(FREQUENCY)
    line = found(motors)
    assert line is not None
    assert line.frequency == pytest.approx(FREQUENCY, abs=2e-3)
    rest = motors[:, :, None].copy()
    line.projected_out(rest, T, np.ones((2, N), dtype=bool))
    values = 2 * (N - line.number(N, T))
    assert np.sum(rest**2) / values == pytest.approx(1.0, abs=5 * np.sqrt(2 / values))


def test_what_is_beside_a_line_stays() -> None:
    """A motion at a frequency 4 Hz away keeps its power."""
    other = of_line(FREQUENCY + 4.0, 1.0)
    rest = other[:, :, None].copy()
    Line(FREQUENCY, 2.0).projected_out(rest, T, np.ones((2, N), dtype=bool))
    assert np.sum(rest**2) > 0.97 * np.sum(other**2)


def test_samples_that_do_not_count_stay_zero() -> None:
    used = np.ones((2, N), dtype=bool)
    used[:, 100:200] = False
    rest = (used * of_line(FREQUENCY))[:, :, None]
    Line(FREQUENCY, 2.0).projected_out(rest, T, used)
    assert not np.any(rest[:, 100:200])


@pytest.mark.parametrize("case", ["noise", "spread over frequencies", "where the motion is", "two"])
def test_other_errors_are_no_line(case: str) -> None:
    wide = np.cumsum(noise(), axis=1)
    motors = {
        "noise": noise(),
        "spread over frequencies": noise() + np.diff(wide, axis=1, prepend=0.0) * 20.0,
        "where the motion is": noise() + of_line(1.5),
        "two": noise() + of_line(FREQUENCY) + of_line(35.0) + of_line(50.0),
    }[case]
    line = found(motors)
    assert line is None
