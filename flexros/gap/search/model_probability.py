"""Evidence: from sums of squares to probabilities that are neither sure beyond reason nor blind for small effects."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.candidates.candidate import names_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Hypothesis
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.residuals.fit_data import FitData

PER_EFFECT = 3.0
"""What an effect costs in the logarithm of the probability, and each of its numbers at most [nats] (tempered;
development seeds)."""
PER_NUMBER = 1.0
"""What each further number of an effect costs at least [nats] (chosen)."""
TEMPER_PLAIN = 2e-4
"""Share of the gap by which effects that are one number of the model may be wrong in form [1] (development seeds)."""
TEMPER_SHAPED = 2e-3
"""The same for effects with a law of their own: friction, gap, spring law, ripple [1] (development seeds)."""
ALONG = 0.6
"""Error of form of two plain effects that do nearly the same, along the line between their predictions, over half of
its length [1] (development seeds)."""
ACROSS = 2e-6
"""The same, whatever they do, as share of the gap [1] (development seeds)."""
MATTERS, DECIDED = 0.5, 7.0
"""Differences of the log-likelihoods between which the error of form decides how sure an answer is [nats] (chosen)."""
REFERRED = 6
"""Times that the reference of the probabilities is moved to the most probable explanation [1] (chosen)."""
LEAST_LEVEL = 0.5
"""Level below which a log has less noise than anything could be told from [1] (chosen)."""
SIGNIFICANT = 4.0
"""Standard deviations of V without gap beyond which something is left [1] (development seeds)."""
UNEXPLAINED = 0.1
"""Share of the gap that an explanation may leave before the cause counts as unknown [1] (the contract)."""
FORM, FORM_ELSEWHERE = 0.02, 0.035
"""The same beside an exact model, in the fitted log and in another one, where only errors of form excuse that more than
the noise is left [1]: between effects of another form (up to 0.015 and 0.025) and causes outside the library (from 0.03
in one of both; development seeds)."""
INADEQUATE = 7.0
"""What leaving more than this costs in the logarithm of the probability, where another explanation does not [nats]
(chosen)."""
ROUNDED = 0.02
"""Gain per value that coarse rounding of an encoder may pretend [1] (chosen)."""
DETECTED = 6.0
"""What a fitted effect must gain beyond its penalty to be detected [1] (development seeds)."""


@dataclass(frozen=True, eq=False)
class ModelComparison:
    """Fits of one log, compared.

    Attributes:
        nothing: The nominal model, with what is tolerated fitted.
        fits: All other fits.
        n_values: Number of prediction errors that count.
        floor_error: Relative standard deviation of the variance of the noise [1].
        rounding: Share of rounding in the variance of the noise, which no model of noise tells exactly [1].
        exact: Whether the nominal model is exact but for the effects.
        distance: Sum of the squares by which the weighted prediction errors of two fits differ; None where not known.
    """

    nothing: CandidateFit
    fits: tuple[CandidateFit, ...]
    n_values: int
    floor_error: float = 0.0
    rounding: float = 0.0
    exact: bool = False
    distance: Callable[[CandidateFit, CandidateFit], float] | None = None

    def level(self, one: CandidateFit) -> float:
        """Return the mean squared weighted prediction error V of a fit; 1 without gap."""
        return one.chi2 / self.n_values

    def gain(self, one: CandidateFit) -> float:
        """Return twice the gain in log-likelihood over the nominal model, with the noise estimated: N ln(V0 / V)."""
        before, after = (max(self.level(fit), LEAST_LEVEL) for fit in (self.nothing, one))
        return self.n_values * float(np.log(before / after))

    def penalty(self, one: CandidateFit) -> float:
        """Return what the fitted numbers cost by the Bayesian information criterion (Schwarz 1978): p ln N."""
        return one.predictor.n_effect * float(np.log(self.n_values))

    def score(self, one: CandidateFit) -> float:
        """Return gain less penalty."""
        return self.gain(one) - self.penalty(one)

    @property
    def spread(self) -> float:
        """Standard deviation of V without gap: sqrt(2 / N), and how well the variance of the noise is known."""
        return float(np.hypot(np.sqrt(2.0 / self.n_values), self.floor_error))

    def significant(self, one: CandidateFit) -> bool:
        """Tell whether a fit leaves more than noise."""
        return self.level(one) - 1.0 > SIGNIFICANT * self.spread

    def strained(self, one: CandidateFit) -> bool:
        """Tell whether a fit moves tolerated numbers farther than their tolerances make it by chance."""
        number = len(one.predictor.tolerance.names)
        return one.price - number > SIGNIFICANT * float(np.sqrt(2.0 * number))

    def left(self, one: CandidateFit) -> float:
        """Return the share of the gap that a fit leaves [1]; zero where what it leaves is not significant.

        Above 1 where it predicts the log worse than the nominal model does.
        """
        if not self.significant(one):
            return 0.0
        return (self.level(one) - 1.0) / max(self.level(self.nothing) - 1.0, SIGNIFICANT * self.spread)

    def adequate(self, one: CandidateFit, form: float = FORM) -> bool:
        """Tell whether a fit leaves no more of the gap than an explanation may.

        Args:
            one: The fit.
            form: What errors of form excuse beside an exact model [1].
        """
        excused = form if self.exact and self.level(one) > 2.0 else UNEXPLAINED
        return self.left(one) <= excused

    def removed(self, before: CandidateFit, after: CandidateFit) -> float:
        """Return the share of what one fit leaves above the floor that another one removes [1]."""
        return (self.level(before) - self.level(after)) / max(self.level(before) - 1.0, 1e-12)

    @property
    def detected(self) -> bool:
        """Whether some effect is worth its numbers beyond what the best of many gains by chance."""
        return any(self.score(one) > self.least for one in self.fits)

    @property
    def least(self) -> float:
        """What an effect must gain beyond its penalty to be detected."""
        return DETECTED + ROUNDED * self.rounding * self.n_values

    def probabilities(self, among: Sequence[CandidateFit]) -> FloatArray:
        """Distribute probability over rival explanations.

        ln p = -(V - V_ref) / (2 V_ref / N + F) - 3 e - c p, with reference to the most probable one and the error of
        form F of the effects in which an explanation differs from it, `form_error`. Each of e effects costs 3, each of
        p further numbers c = ln(n) / 2 by the Bayesian information criterion, between 1 and 3, with the
        n = 1 / (1/N + F / 2 V_ref) values that the errors of form leave.

        Args:
            among: The rivals; the nominal model may be one of them.

        Returns:
            Probabilities that add up to 1, shape (len(among),).
        """
        levels = np.array([self.level(one) for one in among])
        effects = np.array([len(one.predictor.hypothesis) for one in among])
        numbers = np.array([one.predictor.n_effect for one in among]) - effects
        lacking = np.array([not self.adequate(one) for one in among])
        behind = INADEQUATE * (lacking & ~lacking.all())
        place = int(np.argmin(levels))
        logarithm = np.zeros(len(among))
        for _ in range(REFERRED):
            reference = among[place]
            temper = np.array([self._temper(one, reference) for one in among])
            level = max(levels.min(), LEAST_LEVEL)
            scale = 2 * level / self.n_values + temper
            per_number = np.clip(np.log(2 * level / scale) / 2, PER_NUMBER, PER_EFFECT)
            costs = PER_EFFECT * effects + per_number * (numbers - numbers[place])
            logarithm = -(levels - levels[place]) / scale - costs - behind
            if int(np.argmax(logarithm)) == place:
                break
            place = int(np.argmax(logarithm))
        weights = np.exp(logarithm - logarithm.max())
        probabilities: FloatArray = weights / weights.sum()
        return probabilities

    def ranked(self, among: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Sort explanations by probability, those of none by their sums of squares."""
        probabilities = self.probabilities(among)
        order = np.lexsort((np.array([one.chi2 for one in among]), -probabilities))
        return [among[place] for place in order]

    def _temper(self, one: CandidateFit, reference: CandidateFit) -> float:
        """Return the error of form that an explanation may have where it differs from another.

        It is a share of the gap that its own effects close; those that both have are off by the same. Of two of which
        one only adds to the other, it is that of the addition.
        """
        if one.names < reference.names:
            one, reference = reference, one
        contrast = contrast_of(one.predictor.hypothesis, reference.predictor.hypothesis)
        if not contrast.own:
            return 0.0
        without = self._fits_by_names.get(one.names - contrast.own, self.nothing)
        gap = max(self.level(without) - self.level(one), 0.0)
        error = form_error(gap, plain=contrast.plain)
        if not contrast.between or self.distance is None:
            return error
        difference, noise = abs(self.level(one) - self.level(reference)), 2 * self.level(reference) / self.n_values
        if difference < MATTERS * noise or difference > DECIDED * (noise + error):
            return error
        return form_error(gap, plain=True, apart=self.distance(one, reference) / self.n_values)

    @cached_property
    def _fits_by_names(self) -> dict[frozenset[str], CandidateFit]:
        found = {one.names: one for one in reversed(self.fits)}
        return {**found, frozenset(): self.nothing}


@dataclass(frozen=True)
class Contrast:
    """In what one explanation differs from another.

    Attributes:
        own: Names of the effects that the other one lacks.
        plain: Whether each of these is one number of the model or of the signals.
        between: Whether the other one has effects of its own as well and all of both are plain, so that what lies
            between the two predictions tells them apart.
    """

    own: frozenset[str]
    plain: bool
    between: bool


def contrast_of(one: Hypothesis, other: Hypothesis) -> Contrast:
    """Compare the effects of two explanations.

    Args:
        one: Effects of the one.
        other: Effects of the other.
    """
    own, others = names_of(one) - names_of(other), names_of(other) - names_of(one)
    plain = all(candidate.effect.plain for candidate in one if candidate.name in own)
    plain_others = all(candidate.effect.plain for candidate in other if candidate.name in others)
    return Contrast(own, plain, bool(own and others) and plain and plain_others)


def form_error(gap: float, *, plain: bool, apart: float | None = None) -> float:
    """Return what the errors of form of two explanations may make of the difference of their sums of squares.

    F = eps G, a share of the gap. Where two plain effects do nearly the same, F = min(eps G, k^2 D / 2 + 2 a G): the
    truth lies on the line between their predictions, whose distance is D, at one end but for errors of k half lengths
    and of the share a of the gap.

    Args:
        gap: Sum of squares that the effects close, G.
        plain: Whether all effects are one number of the model or of the signals.
        apart: Sum of the squares by which the prediction errors of two plain explanations differ, D; None for others.

    Returns:
        Error in the unit of the sums, so that the difference over 2 + F is what the logarithm of the odds is.
    """
    error = gap * (TEMPER_PLAIN if plain else TEMPER_SHAPED)
    return error if apart is None else min(error, 0.5 * ALONG**2 * apart + 2 * ACROSS * gap)


def evidence_of(
    data: FitData,
    nothing: CandidateFit,
    fits: Sequence[CandidateFit] = (),
    distance: Callable[[CandidateFit, CandidateFit], float] | None = None,
) -> ModelComparison:
    """Compare fits of a log.

    Args:
        data: Log and weights.
        nothing: The nominal model, with what is tolerated fitted.
        fits: All other fits.
        distance: Sum of the squares by which the weighted prediction errors of two fits differ; None where not known.
    """
    measurement = data.measurement
    exact = not nothing.predictor.tolerance.names and not data.record.imported
    error, rounding = measurement.floor_error, measurement.rounding
    return ModelComparison(nothing, tuple(fits), data.n_values, error, rounding, exact, distance)
