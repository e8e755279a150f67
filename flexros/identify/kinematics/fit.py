"""Fit of the unknowns to measured tool positions, with their covariance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.kinematics.elastostatics import measured_points
from flexros.identify.robot_file import IdentifiedValue, identified_file

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.kinematics.record import PoseRecord
    from flexros.identify.kinematics.unknowns import Unknowns
    from flexros.robot import Robot

STEPS = 30
"""Most Gauss-Newton steps (chosen)."""

CONVERGED = 1e-8
"""Largest step, in prior deviations, at which the fit ends (chosen)."""


@dataclass(frozen=True, eq=False)
class KinematicFit:
    """Result of the identification.

    Attributes:
        unknown: The unknowns.
        theta: Their most probable values, shape (P + 6,).
        covariance: Covariance, shape (P + 6, P + 6).
        noise: Noise of each measured coordinate, rms [m]: as given, or estimated.
        residuals: Measured less predicted [m], shape (n, 3).
        before: The same for the nominal robot with its frame fitted.
    """

    unknown: Unknowns
    theta: FloatArray
    covariance: FloatArray
    noise: float
    residuals: FloatArray
    before: FloatArray

    @property
    def deviations(self) -> FloatArray:
        """Standard deviations of theta, shape (P + 6,)."""
        return np.sqrt(np.diag(self.covariance))

    def robot_text(self, source: str) -> str:
        """Return the robot file with identified lengths, zeros and stiffnesses, each with its tolerance."""
        return identified_file(self.unknown.robot, self.identified(), source)

    def robot(self) -> Robot:
        """Return the identified robot."""
        return self.unknown.robot.with_values({name: entry.value for name, entry in self.identified().items()})

    def identified(self) -> dict[str, IdentifiedValue]:
        """Return the identified parameters by name."""
        unknown, found = self.unknown, {}
        rows = zip(unknown.parameters, unknown.values(self.theta), unknown.logarithmic, self.deviations, strict=False)
        for name, value, logarithmic, deviation in rows:
            relative = deviation if logarithmic else deviation / max(abs(value), 1e-12)
            found[name] = IdentifiedValue(float(value), float(relative))
        return found

    def errors(self, record: PoseRecord, *, nominal: bool = False) -> FloatArray:
        """Return distances between measured and predicted tool points of other poses [m], shape (n,).

        Args:
            record: The poses, in the same frame.
            nominal: Whether the nominal robot predicts, with its own best frame for these poses.
        """
        if nominal:
            return np.asarray(np.linalg.norm(_frame_fitted(self.unknown, record), axis=1))
        points, _ = measured_points(self.unknown, record, self.theta)
        return np.asarray(np.linalg.norm(record.tool - points, axis=1))


def fit_kinematics(unknown: Unknowns, record: PoseRecord, noise: float | None = None) -> KinematicFit:
    """Find the most probable unknowns: measurement noise and prior deviations are normal.

        minimise  sum |y - y(theta)|^2 / noise^2 + sum (theta / deviation)^2

    Unknowns that the poses do not tell apart, such as the zero of the first axis and the tracker's frame, keep their
    prior; the covariance says so.

    Args:
        unknown: The unknowns.
        record: Measured poses.
        noise: Noise of each measured coordinate, rms [m]; default: from the residuals, by the degrees of freedom that
            the unknowns leave.

    Raises:
        InputError: Too few poses.
    """
    if 3 * len(record) < 12:
        raise InputError(f"{len(record)} poses were measured, but at least 4 are needed; measure more")
    level = 1e-4 if noise is None else noise
    theta = np.concatenate([np.zeros(len(unknown.parameters)), _frame_guess(unknown, record)])
    for _ in range(3 if noise is None else 1):
        theta, information, residuals = _most_probable(unknown, record, level, theta)
        covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
        if noise is None:
            used = len(theta) - float(np.trace(covariance @ np.diag(unknown.deviation**-2)))
            level = float(np.sqrt(np.sum(residuals**2) / max(residuals.size - used, 1.0)))
    return KinematicFit(unknown, theta, covariance, level, residuals, _frame_fitted(unknown, record))


def _most_probable(
    unknown: Unknowns, record: PoseRecord, noise: float, theta: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return theta, the information about it, and the residuals."""
    prior = unknown.deviation**-2.0
    for _ in range(STEPS):
        points, slopes = measured_points(unknown, record, theta)
        J = slopes.reshape(-1, len(theta))
        residuals = record.tool - points
        information = J.T @ J / noise**2 + np.diag(prior)
        step = np.linalg.solve(information, J.T @ residuals.ravel() / noise**2 - prior * theta)
        theta = theta + step
        if np.max(np.abs(step) / unknown.deviation) < CONVERGED:
            break
    return theta, information, residuals


def _frame_guess(unknown: Unknowns, record: PoseRecord) -> FloatArray:
    """Return the frame that fits the nominal robot best (Kabsch 1976), shape (6,)."""
    from scipy.spatial.transform import Rotation  # loads slowly

    points, _ = measured_points(unknown, record, np.zeros(len(unknown.names)))
    here, there = points - points.mean(axis=0), record.tool - record.tool.mean(axis=0)
    rotation, _ = Rotation.align_vectors(there, here)
    return np.concatenate([record.tool.mean(axis=0) - rotation.apply(points.mean(axis=0)), rotation.as_rotvec()])


def _frame_fitted(unknown: Unknowns, record: PoseRecord) -> FloatArray:
    """Return the residuals of the nominal robot with the frame that fits it best [m], shape (n, 3)."""
    theta = np.concatenate([np.zeros(len(unknown.parameters)), _frame_guess(unknown, record)])
    return np.asarray(record.tool - measured_points(unknown, record, theta)[0])
