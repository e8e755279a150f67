"""How far the sizes of a fit differ between the fitted log and the held-out one, beyond chance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.linearisation import linearised
from flexros.gap.fit.once_per_fit import once_per_fit
from flexros.gap.fit.uncertainty.covariance import fit_covariance, inverse_of, with_variation
from flexros.gap.fit.uncertainty.parts import variation_between_parts

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.settings import RankingSettings


def with_variation_between_logs(
    covariance: FloatArray, fit: CandidateFit, held: FitData, form: RankingSettings | None
) -> FloatArray:
    """Widen a covariance by what the sizes of a fit differ between its log and the held-out one.

    On a real machine sizes take up what is missing. In all parts of one motion that may be the same share, which
    another motion does not confirm. So the held-out log has its own estimate of every size, by one step of Gauss and
    Newton from the fit, and a size is known no better than the two differ beyond chance (DerSimonian and Laird 1986).
    No size changes: the held-out log stays one that was not fitted. Simulated logs lack nothing.

    Args:
        covariance: Covariance by the fitted log, in the units of the fit, shape (n_fitted, n_fitted).
        fit: The fit.
        held: The held-out log.
        form: Settings with the model-form errors of effects.
    """
    if held.record.premises.library_is_complete:
        return covariance
    change, deviations = _estimates(fit, held, form)
    own = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    varying = variation_between_parts(np.vstack([np.zeros_like(change), change]), np.vstack([own, deviations]))
    return with_variation(covariance, varying, fit)


@once_per_fit
def _estimates(fit: CandidateFit, held: FitData, form: RankingSettings | None) -> tuple[FloatArray, FloatArray]:
    """Return how the parameters of a fit change in another log, and their standard deviations by it, shape (n,) each.

    Where its predictions run away, the log says nothing of them.
    """
    line = linearised(fit, held)
    if not np.isfinite(line.chi2):
        return np.zeros(len(fit.theta)), np.full(len(fit.theta), np.inf)
    change = -inverse_of(line.information) @ line.gradient
    return change, np.sqrt(np.maximum(np.diag(fit_covariance(fit, held, form)), 0.0))
