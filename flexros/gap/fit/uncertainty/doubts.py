"""Doubts about a fit that its residuals do not show by themselves: of timing, of dry friction, of the shape of laws."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.friction.friction_curve import FrictionCurve
from flexros.record.missing_samples import bridged_motion
from flexros.record.smoothing import motion_cutoff, smooth_motion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData

TIMING = 0.144
"""Standard deviation of the time between torques and positions of an imported log [samples]: half samples are looked
for, which leaves a quarter of one to each side, all alike probable."""
RISES = (0.002, 0.01, 0.05)
"""Speeds within which dry friction may rise to its level, over the rms speed of the motor [1] (chosen)."""
FARTHEST_SHIFT = 3**0.5
"""Largest shift in time over its standard deviation [1]: that quarter. What errors show beyond is of another cause."""


def of_timing(fit: CandidateFit, data: FitData, residual: FloatArray) -> FloatArray:
    """Return what a standard deviation of the time between torques and positions changes in the errors of a fit.

    When in a sample encoders and torques were taken, and in which order a simulator integrates, nobody writes down.
    A semi-implicit step of a quarter of a sample moves the motion by an eighth, which acts like viscous friction.

    Args:
        fit: The fit.
        data: The log that it was fitted to.
        residual: Its weighted errors, shape (n_values,).
    """
    record = data.record
    if not record.imported or record.command is not None:
        return np.zeros_like(residual)
    before = record.torque[np.maximum(np.arange(record.n_samples) - 1, 0)]
    late = replace(record, torque=(1 - TIMING) * record.torque + TIMING * before)
    torques = data.torques
    if torques is not None:
        torques = replace(torques, torque=torques.torque - TIMING * record.sample_time * torques.rate)
    moved = replace(data, record=late, torques=torques).residuals(fit.predictor, fit.theta[:, None])[:, 0]
    return np.asarray(moved - residual)


def of_smooth_friction(fit: CandidateFit, data: FitData, residual: FloatArray) -> list[FloatArray]:
    """Return what friction that rises smoothly from standstill changes in the errors, for each of the speeds `RISES`.

    Lubricated contacts creep, and many simulators have F tanh(v / s) in place of F sign(v). At low speeds that is less
    friction: taken for a jump, its level comes out too small, and viscous friction too large.

    Args:
        fit: The fit.
        data: The log that it was fitted to.
        residual: Its weighted errors, shape (n_values,).
    """
    record, levels = data.record, np.zeros(data.record.torque.shape[1])
    bent = {one.location for one in fit.hypothesis if one.effect is FrictionCurve}  # a curve has the form already
    for candidate, values in zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True):
        if candidate.effect is CoulombFriction and candidate.location not in bent:
            levels[fit.predictor.robot.joint_names.index(candidate.location)] += values["level"]
    if not record.imported or record.command is not None or not levels.any():
        return []
    position = bridged_motion(record.position, record.valid)
    speed = smooth_motion(position, record.sample_time, motion_cutoff(record.sample_time))[1]
    usual, torques, changes = np.maximum(np.sqrt(np.mean(speed**2, axis=0)), 1e-300), data.torques, []
    for share in RISES:

        def less(at: FloatArray, rise: FloatArray = share * usual) -> FloatArray:
            return np.asarray(levels * (np.sign(at) - np.tanh(at / rise)))

        late = replace(record, torque=record.torque + less(speed))
        moved = replace(data, record=late, torques=None if torques is None else torques.with_more(less(torques.speed)))
        changes.append(np.asarray(moved.residuals(fit.predictor, fit.theta[:, None])[:, 0] - residual))
    return changes


def doubt_of(
    changed: FloatArray,
    J: FloatArray,
    residual: FloatArray,
    inverse: FloatArray,
    farthest: float = FARTHEST_SHIFT,
) -> FloatArray:
    """Return the covariance of the gradient by what a fit does not have, shape (n_fitted, n_fitted).

    With the change c of the errors by a standard deviation of it, such as a shift in time, and its part a that no size
    takes up, the errors tell how much there is of it, t = c'r / (1 + a'a), within a limit, with the variance
    1 / (1 + a'a) of what they leave open.

    Args:
        changed: The change c.
        J: Derivatives of the errors.
        residual: The errors r.
        inverse: H^-1.
        farthest: Largest t [1].
    """
    gradient = J.T @ changed
    shown = 1.0 + max(float(changed @ changed - gradient @ inverse @ gradient), 0.0)
    shift = min(abs(float(changed @ residual)) / shown, farthest)
    return np.asarray((shift**2 + 1.0 / shown) * np.outer(gradient, gradient))


def with_doubt_of_shapes(covariance: FloatArray, inverse: FloatArray, fit: CandidateFit) -> FloatArray:
    """Widen the covariance by what laws of another form leave of a size, where the log may follow one of them.

    A parameter s that shapes a law gets at least the deviation `shape_doubt` of its effect. Fitted with another shape,
    all parameters move along b = column s of H^-1 over its diagonal element, so that (sd^2 - cov_ss) b b' is added.

    Args:
        covariance: Covariance in the units of the fit, shape (n_fitted, n_fitted).
        inverse: H^-1, of the same shape.
        fit: The fit.
    """
    slopes, index, result = fit.predictor.slopes(fit.theta), 0, covariance
    for candidate in fit.hypothesis:
        for free in candidate.free:
            doubt = candidate.effect.shape_doubt.get(free.name, 0.0) / slopes[index]
            added = doubt**2 - result[index, index]
            if added > 0 and inverse[index, index] > 0:
                along = inverse[:, index] / inverse[index, index]
                result = result + added * np.outer(along, along)
            index += 1
    return result
