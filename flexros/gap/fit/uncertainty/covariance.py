"""Covariance of all parameters of a fit, with what the residuals show and with errors of form."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.directions import diverged, switched_off
from flexros.gap.fit.linearisation import linearise, linearised, with_smooth_slopes
from flexros.gap.fit.once_per_fit import once_per_fit
from flexros.gap.fit.uncertainty.coloured_errors import coloured
from flexros.gap.fit.uncertainty.doubts import doubt_of, of_smooth_friction, of_timing, with_doubt_of_shapes
from flexros.gap.fit.uncertainty.parts import estimates_of_parts, parts_of, variation_between_parts

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.linearisation import Linearised
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.settings import RankingSettings

MOST_VARYING = 0.9
"""Largest deviation by variation between parts of a log, over the size [1] (chosen): one above it would say that the
log does not tell whether the effect is there."""


@once_per_fit
def fit_covariance(fit: CandidateFit, data: FitData, form: RankingSettings | None) -> FloatArray:
    """Compute the covariance of all parameters of a fit (White 1980, Huber 1967: the sandwich).

    The predictor of constant gain whitens neither the noise nor what a model leaves: the residuals r have a spectrum S,
    low where the predictor follows the noise, high where something is left. With the derivatives J of the residuals and
    their transforms J(f),

        cov = H^-1 (sum_f J(f)^* S(f) J(f) / n + P P) H^-1,    H = J'J + P,

    with the weight P of the prior of the tolerated deviations, whose truth is of size 1. With S = P = 1 this is H^-1.
    No law of a machine has exactly the form of the library's, and what differs is fitted by the sizes of all effects:
    the share `plain_form` or `shaped_form` of the spectrum of what each effect changes is added to S, all together at
    most `form_over_rest` times the power of what is left. What a shift in time of the torques of an imported log
    changes is added as well, see `of_timing`. Laws of another form also look like another shape, see
    `with_doubt_of_shapes`, and what is missing takes another size in every part of a log of a real machine, see
    `_with_variation`. It is computed once for a fit and a log.

    Args:
        fit: The fit, at its minimum.
        data: The log that it was fitted to.
        form: Settings with the model-form errors of effects; None for what the residuals show alone.

    Returns:
        Covariance in the units of the fit, shape (n_fitted, n_fitted).
    """
    line = linearised(fit, data)
    if fit.predictor.jumps:
        line = with_smooth_slopes(line, fit.predictor, data, fit.theta)
    J, r = line.slopes, line.residual
    prior = line.information - J.T @ J
    meat = prior @ prior  # the gradient of the prior at the truth, whose deviations are of size 1, however it weighs
    n, M = data.spread.shape
    left = r[: M * n, None] if form is None else np.column_stack([r[: M * n], _form_errors(fit, data, r, form)])
    for motor in range(M):
        rows = slice(motor * n, (motor + 1) * n)
        meat += coloured(J[rows], left[rows], int(np.isfinite(data.spread[:, motor]).sum()))
    end = len(r) - (0 if data.torques is None else data.torques.size)
    meat += J[M * n : end].T @ J[M * n : end]
    for begin in range(end, len(r), (len(r) - end) // M or 1):
        rows = slice(begin, begin + (len(r) - end) // M)
        meat += coloured(J[rows], r[rows, None], rows.stop - rows.start)
    inverse = inverse_of(line.information)
    meat += doubt_of(of_timing(fit, data, r), J, r, inverse)
    for changed in of_smooth_friction(fit, data, r):
        meat += doubt_of(changed, J, r, inverse, 1.0)
    covariance: FloatArray = inverse @ meat @ inverse
    if form is not None and fit.predictor.tolerance.left_out.size:
        covariance += inverse @ _of_uninformed(fit, data, J) @ inverse
    if form is not None and not data.record.premises.library_is_complete:
        covariance = with_doubt_of_shapes(covariance, inverse, fit)
        covariance = _with_variation(covariance, inverse, fit, data, line, form)
    # where an unlikely fit nearly diverges, the spectrum overflows
    return covariance if np.all(np.isfinite(covariance)) else np.asarray(inverse)


def _of_uninformed(fit: CandidateFit, data: FitData, J: FloatArray) -> FloatArray:
    """Return the covariance of J'r by tolerated directions that are not fitted, shape (n_fitted, n_fitted).

    The log does not inform in them beside the nominal model, so they stay nominal in all fits (Schmidt 1966: considered
    parameters). Beside effects they matter: the mass of the last body is as uncertain as that of the one before where
    both hang at one joint.

    Args:
        fit: The fit.
        data: The log.
        J: Derivatives of its errors, shape (n, n_fitted).
    """
    predictor, tolerance = fit.predictor, fit.predictor.tolerance
    theta = np.concatenate([fit.theta[: predictor.n_effect], tolerance.by_name(fit.deviations)])
    slopes = linearise(predictor.with_tolerance(replace(predictor.tolerance, directions=None)), data, theta).slopes[
        :, predictor.n_effect :
    ]
    changed = J.T @ (slopes @ tolerance.left_out)
    return np.asarray(changed @ changed.T)


def _with_variation(
    covariance: FloatArray,
    inverse: FloatArray,
    fit: CandidateFit,
    data: FitData,
    line: Linearised,
    form: RankingSettings,
) -> FloatArray:
    """Widen the covariance by what the parameters vary between parts of the log beyond chance.

    Where a law is missing, others take up a part of it, of another size in every part of the log; their common mean is
    an accident of its motion. So a size is known no better than it varies, however long the log is. Chance is what the
    covariance says of a part. Parts tell sizes with a common factor apart too badly to say that there is none.

    Args:
        covariance: Covariance in the units of the fit, shape (n_fitted, n_fitted).
        inverse: H^-1, of the same shape.
        fit: The fit.
        data: The log.
        line: The fit, linearised.
        form: Settings with the number of parts.
    """
    rows = slice(0, data.spread.size)
    prior = np.diag(line.information - line.slopes.T @ line.slopes)
    J, r = line.slopes[rows], line.residual[rows]
    estimates, deviations = estimates_of_parts(J, r, parts_of(data, form.parts), prior, prior * fit.theta)
    coloured_over_white = np.diag(covariance) / np.maximum(np.diag(inverse) * np.mean(r**2), 1e-300)
    varying = variation_between_parts(estimates, deviations * np.sqrt(np.maximum(coloured_over_white, 1.0)))
    return with_variation(covariance, varying, fit)


def with_variation(covariance: FloatArray, varying: FloatArray, fit: CandidateFit) -> FloatArray:
    """Widen a covariance by standard deviations that come on top of its own; correlations stay.

    An effect that the whole log shows varies by no more than its size, a number of the model by no more than its
    tolerance.

    Args:
        covariance: Covariance in the units of the fit, shape (n_fitted, n_fitted).
        varying: What the parameters vary by, in these units, shape (n_fitted,).
        fit: The fit.
    """
    own = np.maximum(np.diag(covariance), 1e-300)
    tolerated = np.ones(len(own) - fit.predictor.n_effect)
    most = np.maximum(np.concatenate([MOST_VARYING * _sizes(fit), tolerated]) ** 2 - own, 0.0)
    wider = np.sqrt(1.0 + np.minimum(varying**2, most) / own)
    return np.asarray(covariance * np.outer(wider, wider))


def _sizes(fit: CandidateFit) -> FloatArray:
    """Return the parameters of the effects without sign, in the units of the fit; of an angle infinity."""
    sizes = [
        np.inf if free.signed and candidate.neutral(free) is None else abs(values[free.name])
        for candidate, values in zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True)
        for free in candidate.free
    ]
    return np.asarray(np.array(sizes) / np.maximum(np.abs(fit.predictor.slopes(fit.theta)), 1e-300))


def _form_errors(fit: CandidateFit, data: FitData, residual: FloatArray, form: RankingSettings) -> FloatArray:
    """Return what each effect changes in the prediction errors of the motors, times its model-form error.

    What sizes take up of a model-form error leaves a rest. So all errors together have at most `form_over_rest` times
    the power of the rest above noise, or of what noise may hide: a large effect of exactly the true form does not make
    the small ones undetermined. On a real machine the floor is a tolerance, above which the rest says nothing.
    """
    if not fit.hypothesis:
        return np.zeros((data.spread.size, 0))
    plain = np.array([candidate.effect.plain for candidate in fit.hypothesis])
    errors = np.sqrt(np.where(plain, form.plain_form, form.shaped_form))
    rows = np.arange(data.spread.size)
    changes = switched_off(fit, data, residual, rows)
    changes = np.where(diverged(changes), 0.0, changes) * errors  # what runs away has no form that it might miss
    if not data.record.premises.floor_is_noise:
        return changes
    power = float(np.sum(changes**2))
    seen = max(float(np.sum(residual[rows] ** 2)) - data.n_values, 0.0)
    hidden = form.significant * float(np.hypot(np.sqrt(2.0 * data.n_values), data.floor_error * data.n_values))
    most = form.form_over_rest * (seen + hidden)
    return changes * np.sqrt(most / power) if power > most else changes


def inverse_of(information: FloatArray) -> FloatArray:
    """Return the inverse of an information matrix; directions without information have no covariance.

    Args:
        information: The matrix, shape (k, k), in any units: parameters of which one is known far better than the
            others do not hide these.
    """
    scale = 1 / np.sqrt(np.maximum(np.diag(information), 1e-300))
    units = np.outer(scale, scale)
    inverse: FloatArray = np.linalg.pinv(information * units, hermitian=True) * units
    return inverse
