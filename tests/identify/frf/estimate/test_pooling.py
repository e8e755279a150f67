"""Pooling of covariances over lines."""

from __future__ import annotations

import numpy as np

from flexros.identify.frf.estimate.pooling import pooled, pooled_degrees, windows

EYE = np.broadcast_to(np.eye(2, dtype=complex), (40, 2, 2))


def scatter_of(covariance: np.ndarray, degrees: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    shape = (len(covariance), 2, degrees)
    noise = (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)
    noise = np.linalg.cholesky(covariance) @ noise
    return np.asarray(noise @ np.conj(np.swapaxes(noise, 1, 2)) / degrees)


def test_windows_are_the_nearest_lines() -> None:
    np.testing.assert_array_equal(windows(5, 1), [[0, 1, 2], [0, 1, 2], [1, 2, 3], [2, 3, 4], [2, 3, 4]])
    assert windows(2, 3).shape == (2, 2)


def test_flat_covariance_gains_degrees_of_freedom() -> None:
    covariance = np.tile(np.array([[2.0, 0.5j], [-0.5j, 1.0]]), (40, 1, 1))
    scatter = scatter_of(covariance, 2, 0)
    before = np.mean(abs(scatter - covariance) ** 2)
    after = np.mean(abs(pooled(scatter, [EYE], 3, 2.0) - covariance) ** 2)
    assert after < 0.25 * before


def test_degrees_of_a_mean_over_lines_that_share_their_data() -> None:
    """Scatters that are moving means of five lines, of which every second is pooled with three on either side."""
    rng = np.random.default_rng(4)
    each = rng.gamma(2.0, 0.5, (4000, 60))
    scatter = np.lib.stride_tricks.sliding_window_view(each, 5, axis=1).mean(axis=2)
    places = np.arange(0, 56, 2)
    mean = scatter[:, places][:, windows(len(places), 3)].mean(axis=2)
    drawn = np.mean(mean.mean(axis=0) ** 2 / mean.var(axis=0))
    claimed = pooled_degrees(2.0 * 5, places, 3, np.array([1.0, 0.8, 0.6, 0.4, 0.2]))
    assert abs(claimed / drawn - 1) < 0.05
    assert pooled_degrees(2.0, places, 3, np.ones(1)) == 2.0 * 7
    assert pooled_degrees(2.0, places, 0, np.ones(1)) == 2.0


def test_form_that_is_flat_is_chosen() -> None:
    """A covariance that grows with the 8th power of the line, flat once multiplied by line^-4."""
    line = np.arange(1.0, 41.0)[:, None, None]
    covariance = line**8 * np.tile(np.eye(2), (40, 1, 1))
    scatter = scatter_of(covariance, 4, 1)
    ratio = pooled(scatter, [EYE, EYE / line**4], 3, 4.0)[:, 0, 0].real / covariance[:, 0, 0]
    assert ratio.min() > 0.3
    assert ratio.max() < 2.5
    assert abs(ratio.mean() - 1) < 0.15


def test_nothing_is_pooled_with_no_neighbours() -> None:
    scatter = scatter_of(np.tile(np.eye(2), (40, 1, 1)), 2, 2)
    assert pooled(scatter, [EYE], 0) is scatter
