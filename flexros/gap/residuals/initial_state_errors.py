"""Prediction errors that come from errors of the initial state alone, which say nothing about a model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.prediction.compiled_plant import in_lanes

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData

LEAST_SEEN = 0.01
"""Root of the sum of squared weighted prediction errors up to which an initial-state error of the size that a settled
predictor has is neglected [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class InitialStateErrors:
    """Directions of weighted prediction errors that come from errors of the initial state alone.

    Attributes:
        motors: Orthonormal basis, rows of the first samples of each motor, shape (M, n_first, k).
        others: The same, rows of the tool measurement and of further sensors, shape (m, k).
    """

    motors: FloatArray
    others: FloatArray

    @property
    def number(self) -> int:
        """Number of directions k."""
        return int(self.others.shape[1])

    def projected_out(self, residual: FloatArray, n: int) -> FloatArray:
        """Project the effect of initial-state errors out of residuals.

        Args:
            residual: Weighted prediction errors of the motors, one after the other, then those of the tool and of
                further sensors, shape (M n + m, sets); changed in place.
            n: Number of samples.

        Returns:
            The same array.
        """
        M, first = self.motors.shape[:2]
        motors, others = residual[: M * n].reshape(M, n, -1)[:, :first], residual[M * n :]
        share = np.einsum("mfk,mfs->ks", self.motors, motors) + self.others.T @ others
        motors -= self.motors @ share
        others -= self.others @ share
        return residual


def initial_state_errors(data: FitData, predictor: Predictor, theta: FloatArray) -> InitialStateErrors:
    """Compute the effect of errors in position and rate of every coordinate before the first sample.

    The arm coordinates are not measured when a log begins, encoders measure the motors with the noise of one sample,
    and torques that are delayed into the log are not in it. Each state is moved by its error in a settled predictor.

    Args:
        data: Log with weights.
        predictor: Predictor of the nominal model.
        theta: Its parameters, shape (n_fitted,).
    """
    first = min(2 * data.gain.settling, data.record.n_samples)
    innovations, poses, errors = _moved_initial_states(data, predictor, theta, first)
    M, k = innovations.shape[1:]
    motors = replace(data, spread=data.spread[:first]).weighted(innovations)
    tool = np.zeros((0, k)) if data.tool is None else data.tool.residuals(poses) - data.tool.residuals(0.0 * poses)
    sensors = np.zeros((0, k)) if data.sensors is None else data.sensors.weighted(errors)
    basis, sizes, _ = np.linalg.svd(np.vstack([motors, tool, sensors]), full_matrices=False)
    basis = basis[:, sizes > LEAST_SEEN]
    return InitialStateErrors(basis[: M * first].reshape(M, first, -1), basis[M * first :])


def _moved_initial_states(
    data: FitData, predictor: Predictor, theta: FloatArray, first: int
) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
    """Change one initial state after the other.

    Returns:
        Changes of the prediction errors [rad or m], shape (first, M, 2 n_coordinates), of the poses of the tool at
        its samples, shape (n_p, 7, 2 n_coordinates), and of the errors of further sensors, shape (m, 2 n_coordinates)
        each.
    """
    record = data.record.part(0, first)
    samples = np.zeros(0, dtype=np.int64) if data.tool is None else data.tool.samples
    early = samples[samples < first]
    moved = np.sqrt(np.diag(data.gain.error))
    states = data.initial_state[:, None] + np.hstack([np.zeros((len(moved), 1)), np.diag(moved)])
    innovations, poses, errors = [], [], []
    for group in in_lanes(states):
        sets = np.repeat(theta[:, None], group.shape[1], axis=1)
        prediction = predictor.predict(
            sets,
            record,
            data.gain,
            predictor.behind_encoders(group, sets),
            pose_samples=early,
            record_states=data.sensors is not None,
        )
        assert prediction.tool_pose is not None
        if data.sensors is not None:
            assert prediction.states is not None
            errors.append(data.sensors.errors(predictor, sets, data.record, prediction.states))
        innovations.append(prediction.innovation[:, :, : group.shape[1]])
        poses.append(prediction.tool_pose[:, :, : group.shape[1]])
    innovation, pose = (np.concatenate(parts, axis=2) for parts in (innovations, poses))
    changed = np.zeros((len(samples), pose.shape[1], len(moved)))
    changed[: len(early)] = pose[:, :, 1:] - pose[:, :, :1]
    of_sensors = [np.concatenate(parts, axis=1) for parts in zip(*errors)]
    return innovation[:, :, 1:] - innovation[:, :, :1], changed, [one[:, 1:] - one[:, :1] for one in of_sensors]
