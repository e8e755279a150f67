"""What a candidate promises to gain beside effects that are fitted already, by linear theory."""

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
"""Share of a direction that rounding leaves where fitted numbers imitate it [1] (chosen)."""
HUGE = 1e200
"""Sum of squared changes beyond which a start has run away [1]."""


def promises(
    predictor: Predictor, data: FitData, starts: FloatArray, plain: FloatArray, lines: Sequence[Linearised]
) -> list[tuple[float, FloatArray]]:
    """Estimate the fall of the sum of squares when a candidate is added, by linear theory, and where to start.

    Every start of the candidate gives a direction, how the errors of the nominal model change with it; the part of it
    that the numbers fitted so far cannot imitate is what counts. The best direction at any length tells what is
    promised, the direction that lowers the sum most as it is tells where to start.

    Args:
        predictor: Predictor of the candidate alone.
        data: Log and weights.
        starts: Its numbers and the tolerated ones to start from, shape (n_fitted, starts).
        plain: Weighted prediction errors of the nominal model, shape (n_values,).
        lines: The fits that it is added to.

    Returns:
        For each of them, the promised fall and the numbers of the candidate to start from, shape (n_effect,).
    """
    promised, lowered = np.zeros(len(lines)), np.full(len(lines), -np.inf)
    chosen = [starts[: predictor.n_effect, 0]] * len(lines)
    for begin in range(0, starts.shape[1], LANES):
        errors = data.residuals(predictor, starts[:, begin : begin + LANES])
        finite = np.all(np.isfinite(errors), axis=0)
        change = np.subtract(errors, plain[:, None], out=errors)
        change[:, ~finite] = 0.0
        for place, line in enumerate(lines):
            gains, falls = _gains(change, line)
            lane = int(np.argmax(falls))
            promised[place] = max(promised[place], float(gains.max()))
            if falls[lane] > lowered[place]:
                lowered[place], chosen[place] = falls[lane], starts[: predictor.n_effect, begin + lane]
    return list(zip(promised.tolist(), chosen))


def _gains(change: FloatArray, line: Linearised) -> tuple[FloatArray, FloatArray]:
    """Return by how much directions may lower the sum of squares of a fit, its own numbers refitted.

    What is tolerated has its price, so that a direction which tolerated deviations imitate still gains what they cost.

    Returns:
        At the best length, and as long as they are, shape (n_directions,) each.
    """
    shared = line.slopes.T @ change
    refitted = np.linalg.lstsq(line.information, shared, rcond=1e-12)[0]
    along = -(line.residual @ change - line.gradient @ refitted)
    length = np.einsum("ij,ij->j", change, change) - np.einsum("ij,ij->j", shared, refitted)
    usable = (along > 0) & (length < HUGE)
    least = IMITATED * np.einsum("ij,ij->j", change, change) + 1e-300
    gains = np.where(usable, along**2 / np.maximum(length, least), 0.0)
    return gains, np.where(length < HUGE, 2 * along - length, -np.inf)
