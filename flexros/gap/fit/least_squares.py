"""Least-squares fit of the parameters of a hypothesis to a log, through its prediction errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.damped_steps import best_step, may_move, predicted_fall
from flexros.gap.fit.linearisation import carried_on, linearise
from flexros.gap.prediction.compiled_plant import LANES
from flexros.gap.settings import FitSettings

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.gap.fit.linearisation import Linearised
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData

FIT = FitSettings()
"""Settings of a fit unless others are given."""
KEPT = 0.3
"""Share of the predicted fall below which further steps are tried [1]."""
LASTING = 0.7
"""Share of the fall that a step promises from which its slopes, corrected, serve for the next one [1] (chosen)."""
ABLE = 0.4
"""Share of the largest predicted fall from which they do [1] (chosen): below it steps are damped much, as along a
valley, where corrected slopes lead on in small steps."""
MANY = 2 * LANES
"""Parameters above which derivatives are corrected (chosen): those of fewer take hardly more time than a step."""
STRAIGHT = 4
"""Iterations in which straight steps suffice where they lower the sum of squares at all."""


def fit(
    predictor: Predictor,
    data: FitData,
    start: FloatArray,
    iterations: int = 12,
    *,
    tolerance_slopes: FloatArray | None = None,
    first_slopes: FloatArray | None = None,
    enough: float | None = None,
    rival: float = np.inf,
    share: float = 0.0,
    roughly: bool = False,
    settings: FitSettings = FIT,
    stop: Callable[[], bool] | None = None,
) -> CandidateFit:
    """Minimise the sum of squares from an initial value (Levenberg 1944, Marquardt 1963).

    Derivatives are differences, computed together in the lanes of the predictor; of many parameters, and of fits that
    are only compared, they are corrected by what a step changed while steps do about what they promise (Broyden 1965).
    Eight dampings are tried at once, each parameter damped by its own information (Marquardt). Where that gains far
    less than predicted, the steps are bent along the curvature of the prediction errors (Transtrum, Sethna 2012), and
    then all parameters are damped equally (Levenberg), so that of two parameters that the log cannot separate the
    better determined one moves.

    Args:
        predictor: Predictor of the hypothesis.
        data: Log and weights.
        start: Initial value in the units of the fit, shape (n_fitted,).
        iterations: Most iterations.
        tolerance_slopes: Derivatives of the weighted prediction errors to the tolerated deviations, held fixed, which
            saves most of the work, shape (n_values, n_tolerated); None to compute them anew in each iteration.
        first_slopes: The same for the first iteration alone.
        enough: Fall of the sum of squares below which the fit ends [1]; default: that of the settings.
        rival: Sum of squares of a better fit: this one ends where it has no hope to come near it.
        share: Fall below which the fit ends as well, over what is left above the floor [1]: where the hypothesis lacks
            much, steps shorten by a constant factor, and a fall of less than one would take dozens of them.
        roughly: Whether the fit is only compared with others.
        settings: Limits of steps and of the end.
        stop: Asked after each iteration; True ends the fit where it is.
    """
    least = settings.enough if enough is None else enough
    theta = np.clip(np.array(start, dtype=float), *predictor.bounds)
    chi2, information, converged, done = np.inf, np.zeros((0, 0)), False, 0
    slopes = first_slopes if tolerance_slopes is None else tolerance_slopes
    known: FloatArray | None = None
    carried: Linearised | None = None
    while done < iterations:
        done += 1
        exact = carried is None and slopes is tolerance_slopes
        line = carried or linearise(predictor, data, theta, slopes, residual=known)
        chi2, information = line.chi2, line.information
        limit = max(least, share * (chi2 - data.n_values)) if share else least
        if not np.isfinite(chi2) or not len(theta):
            break
        predicted = predicted_fall(line, may_move(predictor, theta, line))
        if predicted < limit and not exact:
            slopes, known, carried = tolerance_slopes, line.residual, None
            continue
        if predicted < limit:
            converged = True
            break
        if chi2 - settings.hope * predicted > rival:
            break
        well = KEPT * predicted if done > STRAIGHT else limit
        before, slopes, carried = theta, tolerance_slopes, None
        theta, chi2, known = best_step(predictor, data, theta, line, settings.longest_step, well)
        fall, step = line.chi2 - chi2, theta - before
        does_well = fall > max(LASTING * line.fall_by(step), ABLE * predicted, limit)
        if does_well and (roughly or (len(theta) > MANY and not predictor.jumps)):
            carried = carried_on(line, predictor, data, theta, step, known)
        del line  # slopes are the largest arrays of a fit
        if fall < limit and exact:
            converged = True
            break
        if done < iterations and stop is not None and stop():
            break
    return CandidateFit(predictor, theta, float(chi2), information, done, converged)
