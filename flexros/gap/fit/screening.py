"""Score-test estimate of the likelihood gain of adding a candidate to a fitted model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.prediction.predictor import LANES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.fit.least_squares import Linearised
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData

IMITATED = 1e-12
"""Share of a direction that rounding leaves where the fitted parameters imitate it [1]."""
HUGE = 1e200
"""Sum of squared changes beyond which a prediction has diverged [1]."""


def predicted_gains(
    predictor: Predictor, data: FitData, starts: FloatArray, null_residual: FloatArray, lines: Sequence[Linearised]
) -> list[tuple[float, FloatArray]]:
    """Estimate by how much the sum of squares falls when a candidate is added, by linear theory.

    Each initial value of the candidate gives a direction: the change of the errors of the nominal model. What counts is
    the part of it that the parameters fitted so far cannot imitate. The best direction, scaled to its best length,
    gives the gain; the direction that lowers the sum most without scaling gives the initial value.

    Args:
        predictor: Predictor of the candidate alone.
        data: Log and weights.
        starts: Initial values of its parameters and of the tolerated deviations, shape (n_fitted, n_starts).
        null_residual: Weighted prediction errors of the nominal model, shape (n_values,).
        lines: The fits that the candidate is added to, linearised.

    Returns:
        For each of them, the gain [1] and the initial value of the candidate, shape (n_effect,).
    """
    gains, lowered = np.zeros(len(lines)), np.full(len(lines), -np.inf)
    chosen = [starts[: predictor.n_effect, 0]] * len(lines)
    for begin in range(0, starts.shape[1], LANES):
        errors = data.residuals(predictor, starts[:, begin : begin + LANES])
        finite = np.all(np.isfinite(errors), axis=0)
        change = np.subtract(errors, null_residual[:, None], out=errors)
        change[:, ~finite] = 0.0
        for index, line in enumerate(lines):
            scaled, unscaled = _falls(change, line)
            lane = int(np.argmax(unscaled))
            gains[index] = max(gains[index], float(scaled.max()))
            if unscaled[lane] > lowered[index]:
                lowered[index], chosen[index] = unscaled[lane], starts[: predictor.n_effect, begin + lane]
    return list(zip(gains.tolist(), chosen))


def _falls(change: FloatArray, line: Linearised) -> tuple[FloatArray, FloatArray]:
    """Return by how much directions lower the sum of squares of a fit whose own parameters are fitted again.

    Tolerated deviations have a prior penalty, so that a direction which they imitate still gains what they cost.

    Returns:
        With the best length of each direction, and with the length that it has, shape (n_directions,) each.
    """
    shared = line.slopes.T @ change
    refitted = np.linalg.lstsq(line.information, shared, rcond=1e-12)[0]
    along = -(line.residual @ change - line.gradient @ refitted)
    length = np.einsum("ij,ij->j", change, change) - np.einsum("ij,ij->j", shared, refitted)
    usable = (along > 0) & (length < HUGE)
    least = IMITATED * np.einsum("ij,ij->j", change, change) + 1e-300
    scaled = np.where(usable, along**2 / np.maximum(length, least), 0.0)
    return scaled, np.where(length < HUGE, 2 * along - length, -np.inf)
