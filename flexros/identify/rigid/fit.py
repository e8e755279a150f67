"""Rigid model of a robot from a log, and its torque error on other logs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.log_record import log_record
from flexros.identify.rigid.base_parameters import BaseParameters, base_parameters
from flexros.identify.rigid.excitation import LARGEST_CONDITION, Excitation, judge_excitation
from flexros.identify.rigid.least_squares import Solution, condition_number, covariance, weighted_least_squares
from flexros.identify.rigid.motion_estimate import HIGHEST_CUTOFF, check_rows
from flexros.identify.rigid.record import torque_as_it_acts, torque_at_samples
from flexros.identify.rigid.regression_rows import RegressionRows
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.identify.rigid.settings import RigidSettings

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import BoolArray, FloatArray
    from flexros.logs.time_series import Log
    from flexros.robot import Robot


LARGEST_ERROR = 20.0
"""Largest unexplained share of the torque [%] for which a robot file is written (chosen)."""


@dataclass(frozen=True, eq=False)
class TorqueError:
    """Torque error of the model on one log.

    Attributes:
        label: Name of the log.
        total: 100 |tau - H pi| / |tau| over all motors [%].
        motors: The same of each motor [%], shape (M,); NaN where the torque is zero throughout.
        rows: Number of decimated rows.
    """

    label: str
    total: float
    motors: FloatArray
    rows: int


@dataclass(frozen=True, eq=False)
class RigidFit:
    """Rigid model identified from a log.

    Attributes:
        robot: The robot with its nominal values.
        settings: Settings of the regression.
        base: The base parameters, r of them.
        values: Their values, shape (r,); nominal where the motion does not excite them.
        covariance: Covariance of the values, shape (r, r); zero where the motion does not excite them.
        excitation: Base parameters that the motion excites, k of them.
        factor: Triangular factors of [H, tau] of each motor, which represent all rows, shape (r + 1, M, r + 1).
        information: Normal matrix H' W H of all base parameters, shape (r, r).
        condition: Condition number of the scaled regressor of the excited ones.
        error: Torque error on the log itself.
        error_with_hold: Total error [%] with delay and hold of the command; None where the torque was measured or
            `hold` was set.
        other_cutoff: Another cut-off [Hz] and the total error [%] with it, where the model leaves too much with the
            default one and little enough there; None without.
        cutoff: Cut-off of the low-pass for the positions [Hz].
        rate: Rate after decimation [Hz].
        measured_torque: Whether the torque was measured; else it is the command.
        moving: Which motors moved, shape (M,).
        warnings: Warnings, one sentence each.
    """

    robot: Robot
    settings: RigidSettings
    base: BaseParameters
    values: FloatArray
    covariance: FloatArray
    excitation: Excitation
    factor: FloatArray
    information: FloatArray
    condition: float
    error: TorqueError
    error_with_hold: float | None
    cutoff: float
    rate: float
    measured_torque: bool
    moving: BoolArray
    warnings: tuple[str, ...]
    other_cutoff: tuple[float, float] | None = None

    @property
    def deviation(self) -> FloatArray:
        """Standard deviations of the values, shape (r,); zero where the motion does not excite them."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def hidden(self) -> tuple[int, ...]:
        """Indices of the base parameters that the motion does not excite."""
        return tuple(index for index in range(len(self.values)) if index not in self.excitation.shown)

    @property
    def leakage(self) -> FloatArray:
        """Sensitivity of the excited parameters to errors of the hidden nominal ones, shape (k, r - k)."""
        shown, hidden = list(self.excitation.shown), list(self.hidden)
        at = self.information
        size = np.sqrt(np.diag(at)[shown])
        scaled = at[np.ix_(shown, shown)] / np.outer(size, size)
        return np.linalg.solve(scaled, at[np.ix_(shown, hidden)] / size[:, None]) / size[:, None]

    def force_error(self, values: FloatArray) -> float:
        """Relative torque error [%] on the log with other values of the base parameters, shape (r,)."""
        torque = self.factor[:, :, -1]
        return float(100 * np.linalg.norm(torque - self.factor[:, :, :-1] @ values) / np.linalg.norm(torque))

    @property
    def rich_enough(self) -> bool:
        """Whether the motion excites every base parameter, with a good condition number."""
        return not self.excitation.not_excited and self.condition <= LARGEST_CONDITION


def fit_rigid(
    log: Log,
    robot: Robot,
    settings: RigidSettings | None = None,
    label: str = "the log",
    progress: Callable[[float], None] | None = None,
) -> RigidFit:
    """Identify the rigid model of a robot from a log (Moberg 2007, eq. 4.11 to 4.13).

    Gears and elastic directions are treated as locked, so the motion should not excite the resonances.

    Args:
        log: The log; needs motor positions and a torque.
        robot: The robot.
        settings: Settings of the regression; default: `RigidSettings()`.
        label: Name of the log in messages.
        progress: Called with the processed share of the log.

    Raises:
        InputError: The log does not match the robot, is too short, or has no motion or no torque.
    """
    settings = settings or RigidSettings()
    regressor = RigidRegressor(robot, settings.asymmetric)
    base = base_parameters(regressor, robot.n_motors)
    rows = rows_of_log(log, settings, label, regressor, base)
    check_rows(len(rows.torque), len(base.leading), rows.torque.shape[1])
    held = None if settings.hold else rows.torque_as_it_acts()
    factor = rows.triangular(held, progress)
    fit = _fit(rows, factor, robot, settings, base, label)
    if fit.error.total <= LARGEST_ERROR or settings.cutoff is not None:
        return fit
    return replace(fit, other_cutoff=_lower_cutoff(rows, fit) or _higher_cutoff(rows, fit))


def _lower_cutoff(rows: RegressionRows, fit: RigidFit) -> tuple[float, float] | None:
    """Halve the cut-off until the rigid model leaves little enough, and return it with the error [%] there.

    Accelerations of fast bands are those of the noise of a coarse encoder, or of the motor side of a part that bends.
    None where nothing is left before that.
    """
    cutoff = rows.cutoff
    while True:
        cutoff /= 2
        try:
            found = _error_at(cutoff, rows, fit)
        except InputError:  # too little is left of the log
            return None
        if found <= LARGEST_ERROR:
            return cutoff, found


def _higher_cutoff(rows: RegressionRows, fit: RigidFit) -> tuple[float, float] | None:
    """Double the cut-off until the rigid model leaves little enough, and return it with the error [%] there.

    Motors without load may move faster than the default. None where that needs more than the sampling rate allows.
    """
    cutoff = 2 * rows.cutoff
    while cutoff <= HIGHEST_CUTOFF / rows.record.sample_time:
        found = _error_at(cutoff, rows, fit)
        if found <= LARGEST_ERROR:
            return cutoff, found
        cutoff *= 2
    return None


def _error_at(cutoff: float, rows: RegressionRows, fit: RigidFit) -> float:
    """Fit with another cut-off [Hz], and return the total error [%]."""
    other = RegressionRows.of_record(rows.record, torque_at_samples(rows.record), cutoff, rows.regressor, rows.leading)
    check_rows(len(other.torque), len(rows.leading), other.torque.shape[1])
    return _fit(other, other.triangular(), fit.robot, fit.settings, fit.base, fit.error.label).error.total


def rows_of_log(
    log: Log, settings: RigidSettings, label: str, regressor: RigidRegressor, base: BaseParameters
) -> RegressionRows:
    """Read and filter a log.

    Args:
        log: The log.
        settings: Cut-off, source of the torque, and how commands are paired with positions.
        label: Name of the log, for messages.
        regressor: The regressor.
        base: The base parameters.

    Raises:
        InputError: The log does not fit the robot, is too short, or has no motion or no torque.
    """
    robot = regressor.robot
    record = log_record(
        log,
        robot,
        name=label,
        torque=settings.torque,
        prescribed=settings.prescribed,
        foreign_counts=True,
        standing_counts=True,
    )
    torque = torque_at_samples(record)
    if settings.hold and not record.measured_torque:
        acting, begin = torque_as_it_acts(record, robot.delay)
        record, torque = record.part(begin, record.n_samples), acting[begin:]
    rows = RegressionRows.of_record(record, torque, settings.cutoff_at(1 / record.sample_time), regressor, base.leading)
    if not np.any(rows.motion.moving):
        raise InputError(
            f"{label}: no motion: the position of {', '.join(robot.joint_names)} does not change beyond its noise "
            f"below the cut-off of {rows.cutoff:.4g} Hz; give a log in which the motors move, or a higher cut-off "
            "where they move faster"
        )
    return rows


def _fit(
    rows: RegressionRows, factor: FloatArray, robot: Robot, settings: RigidSettings, base: BaseParameters, label: str
) -> RigidFit:
    """Estimate the excited parameters."""
    n, r = len(rows.torque), len(base.leading)
    H = factor[:, :, :r]
    size = np.linalg.norm(factor[:, :, r], axis=0) / np.sqrt(n)
    excitation = judge_excitation(H / np.where(size > 0, size, 1.0)[:, None], base)
    shown = list(excitation.shown)
    values, solution = _solve(H, factor[:, :, r], n, base, shown)
    residual, moments = _residual(rows, values, shown, solution)
    spread = np.zeros((r, r))
    spread[np.ix_(shown, shown)] = covariance(solution, moments, residual)
    with_hold = None
    if factor.shape[2] > r + 1:
        size_held = np.linalg.norm(factor[:, :, r + 1])
        with_hold = float(100 * np.linalg.norm(_solve(H, factor[:, :, r + 1], n, base, shown)[1].error) / size_held)
    return RigidFit(
        robot=robot,
        settings=settings,
        base=base,
        values=values,
        covariance=spread,
        excitation=excitation,
        factor=factor[:, :, : r + 1],
        information=_information(H, solution.deviation),
        condition=condition_number(H[:, :, shown], solution.deviation),
        error=_error(label, rows.torque, residual),
        error_with_hold=with_hold,
        cutoff=rows.cutoff,
        rate=rows.rate,
        measured_torque=rows.record.measured_torque,
        moving=rows.motion.moving,
        warnings=rows.record.warnings,
    )


def _solve(
    H: FloatArray, torque: FloatArray, n: int, base: BaseParameters, shown: list[int]
) -> tuple[FloatArray, Solution]:
    """Values of all base parameters, nominal for those that are not excited, and the regression of the others."""
    values = base.nominal.copy()
    values[shown] = 0.0
    solution = weighted_least_squares(H[:, :, shown], torque - H @ values, n)
    values[shown] = solution.values
    return values, solution


def _residual(
    rows: RegressionRows, values: FloatArray, shown: list[int], solution: Solution
) -> tuple[FloatArray, FloatArray]:
    """Residual torque, shape (n, M), and its products with the weighted regressor, shape (n, k)."""
    residual, moments = [], []
    for H, torque in rows.blocks():
        residual.append(torque - H @ values)
        moments.append(np.einsum("nmk,nm->nk", H[:, :, shown], residual[-1] / solution.deviation**2))
    return np.concatenate(residual), np.concatenate(moments)


def _information(H: FloatArray, deviation: FloatArray) -> FloatArray:
    """Normal matrix of all base parameters, rows weighted by the deviation of each motor, shape (r, r)."""
    weighted = (H / deviation[:, None]).reshape(-1, H.shape[2])
    information: FloatArray = weighted.T @ weighted
    return information


def cross_test(
    fit: RigidFit, log: Log, label: str = "the log", progress: Callable[[float], None] | None = None
) -> TorqueError:
    """Predict the torques of another log with a fitted model.

    Args:
        fit: The fit.
        log: A log of the same robot.
        label: Name of the log in messages.
        progress: Called with the processed share of the log.

    Returns:
        The torque error, filtered as in the fit.

    Raises:
        InputError: The log does not match the robot, is too short, or has no motion or no torque.
    """
    settings = fit.settings.model_copy(update={"cutoff": fit.cutoff})
    regressor = RigidRegressor(fit.robot, settings.asymmetric)
    rows = rows_of_log(log, settings, label, regressor, fit.base)
    return _error(label, rows.torque, rows.residual(fit.values, progress))


def _error(label: str, torque: FloatArray, residual: FloatArray) -> TorqueError:
    with np.errstate(invalid="ignore", divide="ignore"):
        motors = 100 * np.linalg.norm(residual, axis=0) / np.linalg.norm(torque, axis=0)
        total = float(100 * np.linalg.norm(residual) / np.linalg.norm(torque))
    return TorqueError(label, total, np.where(np.isfinite(motors), motors, np.nan), len(torque))
