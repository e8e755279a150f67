"""Interpolation between four neighbouring samples."""

from __future__ import annotations

import numpy as np

from flexros.record.local_cubic import local_cubic


def test_a_cubic_is_exact_also_at_the_ends() -> None:
    time = np.sort(np.random.default_rng(1).uniform(0, 1, 40))
    at = np.linspace(time[0], time[-1], 101)

    def cubic(t: np.ndarray) -> np.ndarray:
        return (1 - 2 * t + 3 * t**3)[:, None]

    np.testing.assert_allclose(local_cubic(time, cubic(time), at), cubic(at), atol=1e-9)


def test_a_step_moves_nothing_farther_away() -> None:
    time = np.arange(20.0)
    values = np.where(time < 10, 0.0, 1.0)[:, None]
    at = time[:-1] + 0.3
    moved = np.flatnonzero(np.abs(local_cubic(time, values, at)[:, 0] - (at > 10)) > 1e-12)
    assert set(moved) <= {8, 9, 10}
