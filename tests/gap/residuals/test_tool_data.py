"""A tool measurement in the frame of a prediction."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.gap.residuals.tool_data import ToolData, tool_data, tracker_noise
from flexros.random_streams import generator
from flexros.record.record import ToolRecord

T, N, SPREAD = 1e-3, 8000, 2e-5
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
COUNTED = np.ones(N, dtype=bool)
MOST = 10_000


def path(time: np.ndarray) -> np.ndarray:
    return np.stack([0.3 * np.sin(1.1 * time), 0.2 * np.cos(1.7 * time), 0.15 * np.sin(2.3 * time + 1)], axis=1)


def poses() -> np.ndarray:
    """Tool path that does not turn."""
    return np.hstack([path(T * np.arange(N)), np.tile([0.0, 0.0, 0.0, 1.0], (N, 1))])


def measured(rate: float = 130.0, error: np.ndarray | float = 0.0, late: float = 0.0) -> ToolRecord:
    """Measurement of a tracker in its frame, at instants between the samples."""
    time = np.arange(0.0017, (N - 2) * T, 1 / rate)
    noise = SPREAD * np.random.default_rng(0).normal(size=(len(time), 3))
    return ToolRecord(time, (path(time + late) + error) @ TURN.T + np.array([1.0, 2.0, 3.0]) + noise)


def residuals(data: ToolData, predicted: np.ndarray) -> np.ndarray:
    return data.residuals(predicted[data.samples][:, :, None])[:, 0]


def test_frame_offset_and_instants_between_samples_leave_noise_only() -> None:
    data = tool_data(measured(), poses(), COUNTED, T, SPREAD, MOST)
    found = residuals(data, poses())
    assert found @ found / (len(found) - data.basis.shape[1]) == pytest.approx(1.0, abs=0.08)


def test_residuals_hold_nothing_that_the_frame_may_be_off() -> None:
    data = tool_data(measured(), poses(), COUNTED, T, SPREAD, MOST)
    found = residuals(data, poses())
    np.testing.assert_allclose(data.basis.T @ found, 0.0, atol=1e-8)
    np.testing.assert_allclose(data.basis.T @ data.basis, np.eye(data.basis.shape[1]), atol=1e-9)
    shifted = poses()
    shifted[:, 0] += 1e-3
    np.testing.assert_allclose(residuals(data, shifted), found, atol=0.05)


def test_a_vibration_of_the_tool_is_left() -> None:
    data = tool_data(measured(), poses(), COUNTED, T, SPREAD, MOST)
    shaking = poses()
    shaking[:, 1] += 2e-4 * np.sin(2 * np.pi * 9 * T * np.arange(N))
    found = residuals(data, shaking)
    assert found @ found / len(found) == pytest.approx(1 + 0.5 * 10**2 / 3, rel=0.15)


def test_of_many_poses_some_are_taken() -> None:
    data = tool_data(measured(rate=990.0), poses(), COUNTED, T, SPREAD, MOST)
    assert 0.4 * MOST < len(data.position) <= MOST


def test_poses_count_where_the_samples_do() -> None:
    counted = COUNTED.copy()
    counted[:3000] = False
    data = tool_data(measured(), poses(), counted, T, SPREAD, MOST)
    assert data.samples.min() >= 3000
    assert np.all(np.diff(data.samples) > 0)
    assert np.all((data.share >= 0) & (data.share <= 1))
    assert len(data.position) == len(data.row) == len(data.share)


@pytest.mark.parametrize(("late", "word"), [(4e-3, "4 ms later"), (-2.5e-3, "2.5 ms earlier")])
def test_a_clock_that_is_off_by_more_than_a_sample_is_warned_of(late: float, word: str) -> None:
    (warning,) = tool_data(measured(late=late), poses(), COUNTED, T, SPREAD, MOST).warnings
    assert word in warning
    assert tool_data(measured(late=0.2 * late), poses(), COUNTED, T, SPREAD, MOST).warnings == ()


def test_too_few_poses_are_refused() -> None:
    tool = measured()
    with pytest.raises(InputError, match="pose"):
        tool_data(ToolRecord(tool.time[:3], tool.position[:3]), poses(), COUNTED, T, SPREAD, MOST)


@pytest.mark.parametrize(("true", "told"), [(2.1e-5, 2e-5), (1e-4, 1e-4)])
def test_noise_of_the_tracker_is_as_declared_or_as_the_log_shows(true: float, told: float) -> None:
    time = np.arange(4000) / 500
    path = np.stack([0.1 * np.sin(6 * time), np.zeros_like(time), 0.1 * np.cos(6 * time)], axis=-1)
    noise = true * generator(5, 901).normal(size=path.shape)
    assert tracker_noise(ToolRecord(time, path + noise), 2e-5) == pytest.approx(told, rel=0.1)
