"""What errors of the start do to prediction errors, so that a log counts from its first sample."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.prediction.predictor import LANES

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData

LEAST_SEEN = 0.01
"""Weighted prediction errors, root of the sum of squares, up to which an error of the start as large as that of a
settled predictor does not matter [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class StartErrors:
    """Directions of weighted prediction errors that tell of the start alone.

    Attributes:
        motors: Orthonormal basis, rows of the first samples of each motor, shape (M, n_first, k).
        tool: The same, rows of what a tool tracker saw, shape (3 m, k).
    """

    motors: FloatArray
    tool: FloatArray

    @property
    def number(self) -> int:
        """Number of directions k."""
        return int(self.tool.shape[1])

    def taken_off(self, residual: FloatArray, n: int) -> FloatArray:
        """Take off what an error of the start explains.

        Args:
            residual: Weighted prediction errors of the motors, one after the other, then those of the tool, shape
                (M n + 3 m, sets); changed in place.
            n: Number of samples.

        Returns:
            The same array.
        """
        M, first = self.motors.shape[:2]
        motors, tool = residual[: M * n].reshape(M, n, -1)[:, :first], residual[M * n :]
        share = np.einsum("mfk,mfs->ks", self.motors, motors) + self.tool.T @ tool
        motors -= self.motors @ share
        tool -= self.tool @ share
        return residual


def start_errors(data: FitData, predictor: Predictor, theta: FloatArray) -> StartErrors:
    """Find what errors of position and speed of every coordinate before the first sample do.

    Nobody measures where the arm is when a log begins, encoders tell the motors with the noise of one sample, and
    torques that were on their way are not in the log. Each coordinate is moved by the error that a settled predictor
    has of it.

    Args:
        data: Log with weights.
        predictor: Predictor of the nominal model.
        theta: Its numbers, shape (n_fitted,).
    """
    first = min(2 * data.gain.settling, data.record.n_samples)
    innovations, poses = _moved_starts(data, predictor, theta, first)
    M, k = innovations.shape[1:]
    motors = replace(data, spread=data.spread[:first]).weighted(innovations)
    tool = np.zeros((0, k)) if data.tool is None else data.tool.residuals(poses) - data.tool.residuals(0.0 * poses)
    basis, sizes, _ = np.linalg.svd(np.vstack([motors, tool]), full_matrices=False)
    basis = basis[:, sizes > LEAST_SEEN]
    return StartErrors(basis[: M * first].reshape(M, first, -1), basis[M * first :])


def _moved_starts(data: FitData, predictor: Predictor, theta: FloatArray, first: int) -> tuple[FloatArray, FloatArray]:
    """Change one state of the start after the other.

    Returns:
        What that changes of the prediction errors [rad or m], shape (first, M, 2 n_coordinates), and of the poses of
        the tool at its samples, shape (n_p, 7, 2 n_coordinates).
    """
    record = data.record.part(0, first)
    samples = np.zeros(0, dtype=np.int64) if data.tool is None else data.tool.samples
    early = samples[samples < first]
    moved = np.sqrt(np.diag(data.gain.error))
    states = data.start[:, None] + np.hstack([np.zeros((len(moved), 1)), np.diag(moved)])
    innovations, poses = [], []
    for begin in range(0, states.shape[1], LANES):
        group = states[:, begin : begin + LANES]
        sets = np.repeat(theta[:, None], group.shape[1], axis=1)
        found = predictor.predict(sets, record, data.gain, group, pose_samples=early)
        assert found.tool_pose is not None
        innovations.append(found.innovation[:, :, : group.shape[1]])
        poses.append(found.tool_pose[:, :, : group.shape[1]])
    innovation, pose = (np.concatenate(parts, axis=2) for parts in (innovations, poses))
    changed = np.zeros((len(samples), pose.shape[1], len(moved)))
    changed[: len(early)] = pose[:, :, 1:] - pose[:, :, :1]
    return innovation[:, :, 1:] - innovation[:, :, :1], changed
