"""Frames and offsets of a tool measurement are found and taken off."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexros.errors import InputError
from flexros.gap.residuals.tool_frame import CorrectedTool, correct_tool
from flexros.record.record import ToolRecord

pytestmark = pytest.mark.slow

T, N = 1e-3, 8000
NOISE = 2e-5
TURN = Rotation.from_rotvec([0.4, -0.7, 1.9]).as_matrix()
ORIGIN = np.array([1.2, -0.4, 0.3])
OFFSET = np.array([0.02, -0.01, 0.08])


def spatial(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tool path in space with turns about all axes: positions and quaternions."""
    position = np.stack(
        [0.3 * np.sin(1.1 * time), 0.2 * np.cos(1.7 * time), 0.5 + 0.15 * np.sin(2.3 * time + 1)], axis=1
    )
    turns = np.stack([0.5 * np.sin(0.9 * time), 0.4 * np.sin(1.3 * time + 2), 0.6 * np.cos(0.7 * time)], axis=1)
    return position, Rotation.from_rotvec(turns).as_quat()


def planar(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tool path of a planar arm in x and z, turning about y."""
    position = np.stack([0.3 * np.sin(1.1 * time), 0 * time, 0.2 * np.cos(1.7 * time)], axis=1)
    return position, Rotation.from_rotvec(np.outer(0.5 * np.sin(0.9 * time), [0, 1, 0])).as_quat()


def line(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tool path of one prismatic axis."""
    position = np.stack([0.1 * np.sin(1.1 * time) + 0.02 * np.sin(7 * time), 0 * time, 0 * time], axis=1)
    return position, np.tile([0.0, 0, 0, 1], (len(time), 1))


def nearly_straight(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Small slow motion of a planar arm: 110 mm along a line, some across, and turns of 2 degrees."""
    position = np.stack([1.2 + 3e-3 * np.sin(0.7 * time), 0 * time, 0.06 * np.sin(0.7 * time + 0.2)], axis=1)
    return position, Rotation.from_rotvec(np.outer(0.03 * np.sin(1.9 * time), [0, 1, 0])).as_quat()


def measured(path, tau: float = 0.0, offset=OFFSET, rate: float = 250.0, seed: int = 1) -> ToolRecord:
    """Path measured by a tracker in its frame."""
    time = np.arange(0, (N - 1) * T, 1 / rate)
    position, quaternion = path(time + tau)
    seen = (position + Rotation.from_quat(quaternion).apply(offset)) @ TURN.T + ORIGIN
    return ToolRecord(time, seen + NOISE * np.random.default_rng(seed).normal(size=seen.shape))


def corrected(path, record: ToolRecord, oriented: bool = True) -> CorrectedTool:
    position, quaternion = path(np.arange(N) * T)
    return correct_tool(record, position, T, quaternion if oriented else None)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("tau", [0.0, 0.0123, -0.03])
def test_all_is_recovered_in_space(tau: float) -> None:
    found = corrected(spatial, measured(spatial, tau))
    frame = found.frame
    assert rms(found.residual) == pytest.approx(NOISE, rel=0.1)
    assert found.scale == pytest.approx(NOISE, rel=0.1)
    assert np.all(np.isfinite(frame.deviation))
    assert frame.time_offset == pytest.approx(tau, abs=4 * frame.deviation[9])
    np.testing.assert_allclose(frame.tool_offset, OFFSET, atol=4 * frame.deviation[6:9].max())
    np.testing.assert_allclose(frame.origin, ORIGIN, atol=4 * frame.deviation[3:6].max())
    assert np.linalg.norm(Rotation.from_matrix(frame.rotation @ TURN.T).as_rotvec()) < 4 * frame.deviation[:3].max()
    assert frame.deviation[9] < 1e-4
    np.testing.assert_allclose(found.basis.T @ found.basis, np.eye(10), atol=1e-9)


@pytest.mark.parametrize("path", [planar, nearly_straight, line])
def test_what_the_motion_does_not_show_stays_and_the_residual_is_noise(path) -> None:
    found = corrected(path, measured(path, 0.01))
    assert rms(found.residual) == pytest.approx(NOISE, rel=0.1)
    assert found.frame.time_offset == pytest.approx(0.01, abs=1e-4)
    assert found.basis.shape[1] < 10
    assert np.isinf(found.frame.deviation).any()


def test_positions_come_back_to_the_frame_of_the_prediction() -> None:
    found = corrected(spatial, measured(spatial, 0.02))
    np.testing.assert_allclose(found.position, spatial(found.time)[0], atol=6 * NOISE)


def test_outliers_do_not_turn_the_frame() -> None:
    record = measured(spatial, 0.01)
    rows = np.random.default_rng(3).choice(len(record.time), len(record.time) // 20, replace=False)
    spoilt = record.position.copy()
    spoilt[rows] += np.random.default_rng(4).normal(size=(len(rows), 3)) * 0.05
    found = corrected(spatial, ToolRecord(record.time, spoilt))
    good = ~np.isin(found.rows, rows)
    assert rms(found.residual[good]) == pytest.approx(NOISE, rel=0.15)


def test_error_of_the_path_remains_beside_the_basis() -> None:
    record = measured(spatial, 0.0)
    extra = 3e-4 * np.sin(2 * np.pi * 3 * record.time)
    found = corrected(spatial, ToolRecord(record.time, record.position + np.outer(extra, TURN[:, 1])))
    left = found.residual.ravel() - found.basis @ (found.basis.T @ found.residual.ravel())
    assert rms(left.reshape(-1, 3)[:, 1]) == pytest.approx(3e-4 / np.sqrt(2), rel=0.05)


def test_without_orientation_the_tool_offset_is_not_told() -> None:
    found = corrected(spatial, measured(spatial, 0.005, offset=np.zeros(3)), oriented=False)
    assert rms(found.residual) == pytest.approx(NOISE, rel=0.1)
    np.testing.assert_array_equal(found.frame.tool_offset, np.zeros(3))
    assert np.isinf(found.frame.deviation[6:9]).all()


def test_tracker_in_the_base_frame_is_left_there() -> None:
    time = np.arange(0, (N - 1) * T, 4e-3)
    position, _ = spatial(time)
    record = ToolRecord(time, position + NOISE * np.random.default_rng(5).normal(size=position.shape))
    frame = corrected(spatial, record).frame
    np.testing.assert_allclose(frame.rotation, np.eye(3), atol=1e-4)
    assert abs(frame.time_offset) < 5 * frame.deviation[9]


def test_few_poses_are_refused() -> None:
    record = measured(spatial)
    with pytest.raises(InputError, match="^5 poses of the tool .* 20 "):
        corrected(spatial, ToolRecord(record.time[500:505], record.position[500:505]))
