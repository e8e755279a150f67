"""The rigid model of a robot from a log, and how well it predicts the torques of others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.rigid.base_parameters import BaseParameters, base_parameters
from flexros.identify.rigid.excitation import LARGEST_CONDITION, Excitation, judge_excitation
from flexros.identify.rigid.least_squares import Estimate, condition_number, weighted_least_squares
from flexros.identify.rigid.motion_estimate import (
    MotionEstimate,
    check_rows,
    check_size,
    decimate,
    decimation,
    edge,
    estimate_motion,
)
from flexros.identify.rigid.record import RigidRecord, rigid_record
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.identify.rigid.settings import RigidSettings

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import BoolArray, FloatArray
    from flexros.logs.time_series import Log
    from flexros.robot import Robot

_CHUNK_ROWS = 200
"""Decimated rows made at a time, to keep the regressor of a long log small (chosen)."""


@dataclass(frozen=True, eq=False)
class TorqueError:
    """How far the torque of the model is off in one log.

    Attributes:
        label: Name of the log.
        total: 100 |tau - H pi| / |tau| over all motors [%].
        motors: The same of each motor [%], shape (M,); NaN where the torque is zero throughout.
        rows: Decimated rows that it was taken over.
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
        settings: How it was identified.
        base: The base parameters, r of them.
        values: Their values, shape (r,); nominal where the motion does not show them.
        covariance: Covariance of the values, shape (r, r); zero where the motion does not show them.
        excitation: Which base parameters the motion shows, k of them.
        information: Normal matrix H' W H of all base parameters, shape (r, r).
        condition: Condition number of the scaled regressor of those that it shows.
        error: Torque error on the log itself.
        cutoff: Corner of the low-pass for the positions [Hz].
        rate: Rate after decimation [Hz].
        measured_torque: Whether the torque was measured, else it is the command.
        moving: Which motors moved, shape (M,).
        warnings: What was noticed, one sentence each.
    """

    robot: Robot
    settings: RigidSettings
    base: BaseParameters
    values: FloatArray
    covariance: FloatArray
    excitation: Excitation
    information: FloatArray
    condition: float
    error: TorqueError
    cutoff: float
    rate: float
    measured_torque: bool
    moving: BoolArray
    warnings: tuple[str, ...]

    @property
    def deviation(self) -> FloatArray:
        """Standard deviations of the values, shape (r,); zero where the motion does not show them."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def hidden(self) -> tuple[int, ...]:
        """Places of the base parameters that the motion does not show."""
        return tuple(place for place in range(len(self.values)) if place not in self.excitation.shown)

    @property
    def leakage(self) -> FloatArray:
        """What an error of the nominal values of the hidden ones adds to the shown ones, shape (k, r - k)."""
        shown, hidden = list(self.excitation.shown), list(self.hidden)
        at = self.information
        size = np.sqrt(np.diag(at)[shown])
        scaled = at[np.ix_(shown, shown)] / np.outer(size, size)
        return np.linalg.solve(scaled, at[np.ix_(shown, hidden)] / size[:, None]) / size[:, None]

    @property
    def rich_enough(self) -> bool:
        """Whether the motion shows every base parameter, and well conditioned."""
        return not self.excitation.not_excited and self.condition <= LARGEST_CONDITION


@dataclass(frozen=True, eq=False)
class _Rows:
    """Decimated regression of one log: H, shape (n, M, r), and torques [Nm or N], shape (n, M)."""

    H: FloatArray
    torque: FloatArray
    cutoff: float
    rate: float
    moving: BoolArray
    record: RigidRecord


def fit_rigid(
    log: Log,
    robot: Robot,
    settings: RigidSettings | None = None,
    label: str = "the log",
    progress: Callable[[float], None] | None = None,
) -> RigidFit:
    """Identify the rigid model of a robot from a log (Moberg 2007, eq. 4.11 to 4.13).

    Gears and elastic directions are taken as locked, so the motion should not excite the resonances.

    Args:
        log: The log; needs motor positions and a torque.
        robot: The robot.
        settings: How; default: `RigidSettings()`.
        label: Name of the log in texts.
        progress: Called with the share of the log that is in the regression.

    Returns:
        The fit.

    Raises:
        InputError: The log does not fit the robot, has gaps, or is too short.
    """
    settings = settings or RigidSettings()
    regressor = RigidRegressor(robot, settings.asymmetric)
    base = base_parameters(regressor, robot.n_motors)
    rows = _rows(log, settings, label, regressor, base, progress)
    check_rows(len(rows.torque), len(base.leading))
    return _fit(rows, robot, settings, base, label)


def _fit(rows: _Rows, robot: Robot, settings: RigidSettings, base: BaseParameters, label: str) -> RigidFit:
    """Estimate what the motion shows."""
    size = np.sqrt(np.mean(rows.torque**2, axis=0))
    excitation = judge_excitation(rows.H / np.where(size > 0, size, 1.0)[:, None], base)
    values, estimate = _estimate(rows, base, excitation)
    shown = list(excitation.shown)
    covariance = np.zeros((len(values), len(values)))
    covariance[np.ix_(shown, shown)] = estimate.covariance
    return RigidFit(
        robot=robot,
        settings=settings,
        base=base,
        values=values,
        covariance=covariance,
        excitation=excitation,
        information=_information(rows.H, estimate.deviation),
        condition=condition_number(rows.H[:, :, shown], estimate.deviation),
        error=_error(label, rows.torque, estimate.residual),
        cutoff=rows.cutoff,
        rate=rows.rate,
        measured_torque=rows.record.measured,
        moving=rows.moving,
        warnings=rows.record.warnings,
    )


def _estimate(rows: _Rows, base: BaseParameters, excitation: Excitation) -> tuple[FloatArray, Estimate]:
    """Values of all base parameters, nominal for those that are not shown, and the regression of the others."""
    shown = list(excitation.shown)
    values = base.nominal.copy()
    values[shown] = 0.0
    estimate = weighted_least_squares(rows.H[:, :, shown], rows.torque - rows.H @ values)
    values[shown] = estimate.values
    return values, estimate


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
        label: Name of the log in texts.
        progress: Called with the share of the log that was predicted.

    Returns:
        The torque error, filtered as in the fit.

    Raises:
        InputError: The log does not fit the robot, has gaps, or is too short.
    """
    settings = fit.settings.model_copy(update={"cutoff": fit.cutoff})
    rows = _rows(log, settings, label, RigidRegressor(fit.robot, settings.asymmetric), fit.base, progress)
    return _error(label, rows.torque, rows.torque - rows.H @ fit.values)


def _rows(
    log: Log,
    settings: RigidSettings,
    label: str,
    regressor: RigidRegressor,
    base: BaseParameters,
    progress: Callable[[float], None] | None,
) -> _Rows:
    """Filter a log and build its decimated regression, a stretch at a time."""
    record = rigid_record(log, regressor.robot, label, settings.hold)
    cutoff = settings.cutoff_at(1 / record.sample_time)
    motion = estimate_motion(record.position, record.sample_time, cutoff)
    _check_signals(record, motion, regressor.robot, label)
    factor = decimation(record.sample_time, cutoff)
    half, n = edge(factor), len(record.position)
    check_size((n - 2 * half) // factor, record.torque.shape[1], len(base.leading))
    parts = []
    for start in range(0, n - 2 * half, _CHUNK_ROWS * factor):
        cut = slice(start, min(start + (_CHUNK_ROWS - 1) * factor + 2 * half + 1, n))
        H = regressor.matrix(motion.position[cut], motion.velocity[cut], motion.acceleration[cut])
        parts.append(decimate(H[:, :, list(base.leading)], factor))
        if progress is not None:
            progress(cut.stop / n)
    torque = decimate(record.torque, factor)
    rate = 1 / (record.sample_time * factor)
    return _Rows(np.concatenate(parts), torque, cutoff, rate, motion.moving, record)


def _check_signals(record: RigidRecord, motion: MotionEstimate, robot: Robot, label: str) -> None:
    """Refuse a log without motion or without torque."""
    names = ", ".join(robot.joint_names)
    if not np.any(motion.moving):
        raise InputError(
            f"{label}: no motion: the position of {names} does not change beyond its noise; give a log in which the "
            "motors move"
        )
    if not np.any(record.torque):
        raise InputError(
            f"{label}: the torque of {names} is zero throughout; give a log with torques"
        )


def _error(label: str, torque: FloatArray, residual: FloatArray) -> TorqueError:
    with np.errstate(invalid="ignore", divide="ignore"):
        motors = 100 * np.linalg.norm(residual, axis=0) / np.linalg.norm(torque, axis=0)
        total = float(100 * np.linalg.norm(residual) / np.linalg.norm(torque))
    return TorqueError(label, total, np.where(np.isfinite(motors), motors, np.nan), len(torque))
