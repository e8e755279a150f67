"""Whether the size of an effect is the same throughout a log: an imitation of something else has another one each time.

Each part of the log has its own best sizes of all effects, by linear theory. A true effect beside something that no
effect explains has about the same size in every part; an effect that only imitates what is missing follows it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.estimates import sizes_of
from flexros.gap.fit.linearisation import linearised
from flexros.gap.fit.once_per_fit import once_per_fit
from flexros.gap.fit.uncertainty.parts import estimates_of_parts, parts_of

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.settings import RankingSettings

DEVIATION = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation [1]."""


@once_per_fit
def constancies(fit: CandidateFit, data: FitData, settings: RankingSettings) -> dict[str, float]:
    """Compute how constant the size of each effect of a fit is over its log; computed once for a fit and a log.

    Args:
        fit: The fit, near its minimum.
        data: The log.
        settings: Parts of the log, and which of them count.

    Returns:
        As `constancy` has it, by effect@location; zero where too few parts of the log inform on a size.
    """
    line = linearised(fit, data)
    n, M = data.spread.shape
    rows = slice(0, M * n)  # those of the motors: other sensors have instants of their own
    part = parts_of(data, settings.parts)
    prior = np.diag(line.information - line.slopes.T @ line.slopes)
    estimates, deviations = estimates_of_parts(line.slopes[rows], line.residual[rows], part, prior, prior * fit.theta)
    found, column = {}, 0
    for candidate in fit.hypothesis:
        free = sizes_of(candidate)[0]
        index = column + candidate.free.index(free)
        # positive sizes are fitted by their logarithm, whose change is the relative change of the size
        whole = float(fit.theta[index]) if free.signed else 1.0
        shown = abs(whole) > settings.shown_by_part * deviations[:, index]
        found[candidate.name] = constancy(whole + estimates[shown, index], settings.fewest_parts)
        column += len(candidate.free)
    return found


def constancy(sizes: FloatArray, fewest: int) -> float:
    """Return the median of some estimates over its standard deviation, both robust [1]; zero for too few estimates.

    A single part in which something else happens, such as an impact, moves neither.

    Args:
        sizes: Estimates of a size, shape (K,).
        fewest: Fewest estimates from which anything can be said.
    """
    if len(sizes) < fewest or not np.all(np.isfinite(sizes)):
        return 0.0
    middle = float(np.median(sizes))
    deviation = DEVIATION * float(np.median(np.abs(sizes - middle)))
    return float(np.sqrt(len(sizes)) * abs(middle) / max(deviation, 1e-9 * abs(middle) + 1e-300))
