"""Fits of an explanation with fewer parameters: without those that nothing tells, and those that are no findings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.initial_values import starts_of
from flexros.gap.fit.limits import at_limits
from flexros.gap.fit.pruning import without_least_parameter
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.search.fits.refits import Refits

if TYPE_CHECKING:
    from collections.abc import Collection

    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit

ANEW = 2
"""Initial values from which a law is fitted again, the best ones [1] (chosen)."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SimplerFits(Refits):
    """Fits of explanations with fewer parameters; see `LogFits`."""

    def pruned(self, fit: CandidateFit) -> CandidateFit:
        """Leave out the parameters of a fit that the information criterion rejects (Schwarz 1978).

        So it does with parts of a law that extends others, such as a hump of friction that yields.

        Args:
            fit: The fit.

        Returns:
            A fit of the same effects with fewer parameters, or the same fit.
        """
        n = self.data.n_values
        while (fewer := without_least_parameter(fit)) is not None and not self.deadline.stops_finishing():
            hypothesis, theta = fewer
            most = fit.chi2 * np.exp(np.log(n) / n)
            pruned = self._final(self.null.predictor(hypothesis, fit.predictor.plant), theta, rival=most)
            if not pruned.chi2 < most:
                break
            fit = pruned
        parts = [(law, next(iter(part))) for law in fit.hypothesis for part in law.effect.extends.values()]
        for law, part in parts:
            rest = None if self.deadline.stops_finishing() else law.without_part(part)
            saved = 0 if rest is None else len(law.free) - len(rest.free)
            if rest is None or not saved:
                continue
            most = fit.chi2 * np.exp(saved * np.log(n) / n)
            pruned = self._with_fewer(fit, law, rest, rival=most)
            if pruned.chi2 < most:
                fit = pruned
        return fit

    def within_limits(self, fit: CandidateFit) -> CandidateFit:
        """Fit again without parameters that ended at a limit of their search, which are no findings.

        The search is widened where its range goes on. A law whose shape is at a limit is begun anew: where bodies stick
        and slip, the sum of squares has many minima along it. Is it there again, it is set to its usual value. A
        part of a law whose size is at a limit nevertheless is left out, as a hump of friction so narrow that only its
        bristles are left; so is an effect of that part alone.

        Args:
            fit: The fit.

        Returns:
            A fit without such parameters, or the same fit.
        """
        begun: set[str] = set()
        for _ in range(2 * fit.predictor.n_effect):
            limited = at_limits(fit)
            if not limited:
                break
            candidate, name = limited[0]
            factor = _common_factor(fit, [one.location for one, _ in limited])
            if factor:
                fit = self.without(fit, factor)
                continue
            wide, shaped = candidate.widened(name), candidate.with_usual(name) or candidate.without_part(name)
            if wide is not None:
                fit = self.reshaped(fit, tuple(wide if one is candidate else one for one in fit.hypothesis))
            elif shaped is None:
                fit = self.without(fit, candidate.name)
            else:
                anew = None if candidate.name in begun else self._begun_anew(fit, candidate)
                begun.add(candidate.name)
                fit = anew or self._with_fewer(fit, candidate, shaped)
        return fit

    def _begun_anew(self, fit: CandidateFit, law: Candidate) -> CandidateFit | None:
        """Fit an explanation again from initial values of one of its laws; None where that is no better within limits.

        Args:
            fit: The fit.
            law: The law.
        """
        starts = starts_of((law,))
        thetas = np.repeat(fit.theta[:, None], starts.shape[1], axis=1)
        thetas[fit.columns([law.name])] = starts
        best = np.argsort(chi2_of(fit.predictor, self.data, thetas))[:ANEW]
        fits = [self._final(fit.predictor, theta) for theta in thetas[:, best].T if not self.deadline.stops_finishing()]
        within = [one for one in fits if one.chi2 < fit.chi2 and law not in dict(at_limits(one))]
        return min(within, key=lambda one: one.chi2, default=None)

    def _with_fewer(
        self, fit: CandidateFit, candidate: Candidate, fewer: Candidate, rival: float = np.inf
    ) -> CandidateFit:
        """Fit an explanation to the end with one of its candidates replaced by the same with fewer free parameters."""
        names = {free.name for free in fewer.free}
        kept = [one is not candidate or free.name in names for one in fit.hypothesis for free in one.free]
        theta = fit.theta[np.array([*kept, *([True] * len(fit.deviations))], dtype=bool)]
        changed = tuple(fewer if one is candidate else one for one in fit.hypothesis)
        return self._final(self.null.predictor(changed, fit.predictor.plant), theta, rival=rival)


def _common_factor(fit: CandidateFit, locations: Collection[str]) -> str:
    """Return the name of an effect that may have taken others at its motor to a limit with it; empty for none.

    Args:
        fit: The fit.
        locations: Where sizes ended at a limit.
    """
    values = zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True)
    factors = {one.location: one.name for one, v in values if v.get(one.effect.common_factor, 0.0) > 0}
    return next((factors[location] for location in locations if location in factors), "")
