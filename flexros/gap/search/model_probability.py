"""Posterior model probabilities from sums of squares, tempered for model-form error."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.candidates.candidate import names_of
from flexros.gap.candidates.one_scale import of_one_scale
from flexros.gap.settings import RankingSettings

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Hypothesis
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData

RANKING = RankingSettings()
"""Settings of a comparison unless others are given."""
LEAST_LEVEL = 0.5
"""Mean squared error below which a log has too little noise to conclude anything [1]."""


@dataclass(frozen=True, eq=False)
class ModelComparison:
    """Fits of one log, compared.

    Attributes:
        null: The nominal model, with what is tolerated fitted.
        fits: All other fits.
        n_values: Number of prediction errors that count.
        floor_error: Relative standard deviation of the noise variance [1].
        noise_level: Mean squared error by noise alone, below 1 where a tolerance of torques adds to it [1].
        rounding: Share of rounding in the noise variance, which no noise model describes exactly [1]: mean over all
            values, as what rounding feigns at one encoder is among the values of that one.
        exact: Whether the nominal model is exact but for the effects.
        distance: Sum of the squares by which the weighted prediction errors of two fits differ; None where not known.
        chance: What the sums of squares of two fits of a measured log of torques may differ by without evidence [1];
            None for other logs.
        settings: Thresholds and costs.
    """

    null: CandidateFit
    fits: tuple[CandidateFit, ...]
    n_values: int
    floor_error: float = 0.0
    noise_level: float = 0.0
    rounding: float = 0.0
    exact: bool = False
    distance: Callable[[CandidateFit, CandidateFit], float] | None = None
    chance: Callable[[CandidateFit, CandidateFit], float] | None = None
    settings: RankingSettings = RANKING

    def level(self, fit: CandidateFit) -> float:
        """Return the mean squared weighted prediction error V of a fit [1]; 1 without gap."""
        return fit.chi2 / self.n_values

    def beyond_noise(self, level: float, noise: float | None = None) -> float:
        """Return what a mean squared error has beyond noise, over what the tolerance of torques adds [1].

        1 where errors are as large as the tolerance allows for, 0 where they are noise alone. The noise of encoders may
        be most of the floor: beside it, torques that are known exactly hardly lower the level.

        Args:
            level: The mean squared error [1].
            noise: That of noise alone [1], see `levels_of_noise`; default: as measured.
        """
        noise = self.noise_level if noise is None else noise
        return max(level - noise, 0.0) / max(1.0 - noise, 1e-12)

    @property
    def levels_of_noise(self) -> tuple[float, ...]:
        """Mean squared errors that noise alone may leave [1]: as measured, and none where a fit refutes that.

        Noise of an encoder is measured from what is not smooth in its positions. An arm that shakes has much of that,
        and a fit that explains the shaking leaves less than such noise would.
        """
        least = min(self.level(fit) for fit in (self.null, *self.fits))
        return (self.noise_level,) if least >= self.noise_level else (self.noise_level, 0.0)

    def gain(self, fit: CandidateFit) -> float:
        """Return twice the gain in log-likelihood over the nominal model, noise estimated: N ln(V0 / V) [1]."""
        null_level, level = max(self.level(self.null), LEAST_LEVEL), max(self.level(fit), LEAST_LEVEL)
        return self.n_values * float(np.log(null_level) - np.log(level))  # minus infinity where the fit diverged

    def penalty(self, fit: CandidateFit) -> float:
        """Return the penalty of the effects' parameters by the information criterion (Schwarz 1978): p ln N [1]."""
        return fit.predictor.n_effect * float(np.log(self.n_values))

    def score(self, fit: CandidateFit) -> float:
        """Return gain less penalty [1]."""
        return self.gain(fit) - self.penalty(fit)

    @property
    def spread(self) -> float:
        """Standard deviation of V without gap [1]: sqrt(2 / N), and how well the noise variance is known."""
        return float(np.hypot(np.sqrt(2.0 / self.n_values), self.floor_error))

    def significant(self, fit: CandidateFit) -> bool:
        """Return whether a fit leaves more than noise."""
        return self.level(fit) - 1.0 > self.settings.significant * self.spread

    def beyond_tolerance(self, fit: CandidateFit) -> bool:
        """Return whether a fit moves tolerated parameters farther than chance would within their tolerances."""
        n = fit.predictor.tolerance.n_free
        return fit.prior_penalty - n > self.settings.significant * float(np.sqrt(2.0 * n))

    def remainder(self, fit: CandidateFit) -> float:
        """Return the share of the gap that a fit leaves [1]; zero where what it leaves is not significant.

        Above 1 where it predicts the log worse than the nominal model does.
        """
        if not self.significant(fit):
            return 0.0
        gap = max(self.level(self.null) - 1.0, self.settings.significant * self.spread)
        return (self.level(fit) - 1.0) / gap

    def adequate(self, fit: CandidateFit, *, elsewhere: bool = False) -> bool:
        """Return whether a fit leaves no more of the gap than an explanation may.

        Args:
            fit: The fit.
            elsewhere: Whether this log is another one than the fitted one.
        """
        settings = self.settings
        exact = settings.exact_unexplained_elsewhere if elsewhere else settings.exact_unexplained
        return self.remainder(fit) <= (exact if self.exact and self.level(fit) > 2.0 else settings.unexplained)

    def removed(self, before: CandidateFit, after: CandidateFit) -> float:
        """Return the share of what one fit leaves above the floor that another one removes [1]."""
        return (self.level(before) - self.level(after)) / max(self.level(before) - 1.0, 1e-12)

    @property
    def detected(self) -> bool:
        """Whether some effect gains more than the best of many does by chance."""
        return any(self.score(fit) > self.threshold for fit in self.fits)

    @property
    def threshold(self) -> float:
        """Score that an effect must exceed to be detected [1]."""
        return self.settings.detected + self.settings.rounded * self.rounding * self.n_values

    def probabilities(self, rivals: Sequence[CandidateFit]) -> FloatArray:
        """Distribute probability over rival explanations.

        ln p = -(V - V_ref) / (2 V_ref / N + F) - c_e e - c p, relative to the most probable one, where F is the
        model-form error of the effects in which an explanation differs from it, see `form_error`. Each of e effects
        costs c_e = 3, each of p further parameters c = ln(n) / 2 by the Bayesian information criterion, between 1 and
        3, with the n = 1 / (1/N + F / 2 V_ref) values that the model-form error leaves.

        Args:
            rivals: The rivals; the null fit may be one of them.

        Returns:
            Probabilities that add up to 1, shape (len(rivals),).
        """
        index = int(np.argmin([self.level(fit) for fit in rivals]))
        odds: dict[int, FloatArray] = {}
        while index not in odds:
            odds[index] = self._odds(rivals, index)
            index = int(np.argmax(odds[index]))
        circle = {one: odds[one] for one in list(odds)[list(odds).index(index) :]}
        logarithm = _consistent(circle)
        weights = np.exp(logarithm - logarithm.max())
        probabilities: FloatArray = weights / weights.sum()
        return probabilities

    def _odds(self, rivals: Sequence[CandidateFit], index: int) -> FloatArray:
        """Return the logarithms of the odds of explanations to one of them [1], see `probabilities`."""
        settings, reference = self.settings, rivals[index]
        levels = np.array([self.level(fit) for fit in rivals])
        effects = np.array([len(fit.hypothesis) for fit in rivals])
        parameters = np.array([fit.predictor.n_effect for fit in rivals]) - effects
        lacking = np.array([not self.adequate(fit) for fit in rivals])
        behind = settings.inadequate * (lacking & ~lacking.all())
        temper = np.array([self._temper(fit, reference) for fit in rivals])
        level = max(levels.min(), LEAST_LEVEL)
        scale = 2 * level / self.n_values + temper
        per_parameter = np.clip(np.log(2 * level / scale) / 2, settings.per_parameter, settings.per_effect)
        costs = settings.per_effect * effects + per_parameter * (parameters - parameters[index])
        logarithm = -(levels - levels[index]) / scale - costs - behind
        return np.asarray(logarithm - logarithm[index])

    def ranked(self, rivals: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Sort explanations by probability, those of probability zero by their sums of squares."""
        probabilities = self.probabilities(rivals)
        order = np.lexsort((np.array([fit.chi2 for fit in rivals]), -probabilities))
        return [rivals[index] for index in order]

    def _temper(self, fit: CandidateFit, reference: CandidateFit) -> float:
        """Return the model-form error that an explanation may have where it differs from another one.

        It is a share of the gap that its own effects close; effects of both have the same error in both. Where one of
        the two only adds to the other, it is that of the addition. A gain and an inertia of one scale differ by no more
        than chance where the parts of a measured log do not agree (Vuong 1989, with parts for single values).
        """
        if fit.names < reference.names:
            fit, reference = reference, fit
        contrast = contrast_of(fit.hypothesis, reference.hypothesis)
        if not contrast.own:
            return 0.0
        gap = max(self._least_level_of(fit.names - contrast.own) - self.level(fit), 0.0)
        error = form_error(gap, plain=contrast.plain, settings=self.settings)
        if contrast.one_scale and self.chance is not None:
            return max(error, self.chance(fit, reference) / self.n_values)
        if not contrast.between or self.distance is None:
            return error
        difference, noise = abs(self.level(fit) - self.level(reference)), 2 * self.level(reference) / self.n_values
        if difference < self.settings.matters * noise or difference > self.settings.decided * (noise + error):
            return error
        distance = self.distance(fit, reference) / self.n_values
        error = form_error(gap, plain=contrast.plain, distance=distance, settings=self.settings)
        # by noise alone, levels differ no more than that: the rest is form error along the line, and no evidence
        believable = max(distance + 2 * math.sqrt(distance * self.level(reference) / self.n_values), 1e-300)
        return max(error, noise * (difference / believable - 1.0))

    def _least_level_of(self, names: frozenset[str]) -> float:
        """Return the level that some effects leave [1], or the least of parts of them that were fitted."""
        if names not in self._levels:
            parts = (self.level(fit) for fit in (self.null, *self.fits) if fit.names <= names)
            self._levels[names] = min(parts)
        return self._levels[names]

    @cached_property
    def _levels(self) -> dict[frozenset[str], float]:
        return {}


@dataclass(frozen=True)
class Contrast:
    """The effects in which one explanation differs from another.

    Attributes:
        own: Names of the candidates that the other one lacks.
        plain: Whether the effects of all of these are plain, see `AbstractEffect.plain`.
        between: Whether the other one has candidates of its own as well and all of both are plain, or all harmonics of
            the same rotors, or Coulomb and load-dependent friction of the same motors, so that the distance between the
            two predictions separates them: what such a harmonic has of other orders, it has wherever it enters, and
            how dry friction sticks does not depend on what its level follows.
        one_scale: Whether they differ in a gain of a torque and an inertia alone, see `of_one_scale`.
    """

    own: frozenset[str]
    plain: bool
    between: bool
    one_scale: bool


def contrast_of(hypothesis: Hypothesis, other: Hypothesis) -> Contrast:
    """Compare the effects of two explanations."""
    own, others = names_of(hypothesis) - names_of(other), names_of(other) - names_of(hypothesis)
    plain = all(candidate.effect.plain for candidate in hypothesis if candidate.name in own)
    plain_others = all(candidate.effect.plain for candidate in other if candidate.name in others)
    rotors, rotors_of_others = _rotors(hypothesis, own), _rotors(other, others)
    friction, friction_of_others = _one_level(hypothesis, own), _one_level(other, others)
    alike = (
        (plain and plain_others)
        or (rotors is not None and rotors == rotors_of_others)
        or (friction is not None and friction == friction_of_others)
    )
    pair = [one for one in (*hypothesis, *other) if one.name in own ^ others]
    one_scale = len(own) == len(others) == 1 and of_one_scale(*pair)
    return Contrast(own, plain, bool(own and others) and alike, one_scale)


def _rotors(hypothesis: Hypothesis, names: frozenset[str]) -> list[str] | None:
    """List the motors of some candidates of an explanation; None where one of them is no harmonic of a rotor."""
    chosen = [candidate for candidate in hypothesis if candidate.name in names]
    return sorted(one.location for one in chosen) if all(one.effect.harmonics for one in chosen) else None


def _one_level(hypothesis: Hypothesis, names: frozenset[str]) -> list[str] | None:
    """List the motors of some candidates of an explanation; None where one is no dry friction of one level."""
    chosen = [candidate for candidate in hypothesis if candidate.name in names]
    return sorted(one.location for one in chosen) if all(one.effect.one_level for one in chosen) else None


def _consistent(circle: Mapping[int, FloatArray]) -> FloatArray:
    """Return logarithms of odds that do not contradict each other.

    Odds to different explanations may go round in a circle, as each pair has its own model-form error: a law that hides
    behind the error of a rich one is refuted by a third one that shares this with it. Then the explanation counts that
    the others beat least (the minimax rule of votes), and odds to it hold by way of each of the others.

    Args:
        circle: Odds of all explanations to each of some of them, by its number: the most probable explanation by the
            odds to one is the next one, and that by the odds to the last one is the first.
    """
    first = min(circle, key=lambda one: max(circle[one][other] for other in circle))
    return np.asarray(np.min([odds + circle[first][one] for one, odds in circle.items()], axis=0))


def form_error(gap: float, *, plain: bool, distance: float | None = None, settings: RankingSettings = RANKING) -> float:
    """Return what the model-form errors of two explanations may change in the difference of their sums of squares.

    F = eps G, a share of the gap. Where two plain effects, two harmonics of a rotor, or Coulomb and
    load-dependent friction of a motor do nearly the same,
    F = min(eps G, k^2 D / 2 + 2 a G): the truth is on the line between their predictions, whose distance is D, at one
    end but for errors of k half lengths along it and of the share a of the gap across it.

    Args:
        gap: Sum of squares that the effects close, G [1].
        plain: Whether all effects are plain.
        distance: Sum of the squares by which the prediction errors of two such explanations differ, D [1]; None for
            others.
        settings: The shares eps and a, and k.

    Returns:
        Error in the unit of the sums of squares, so that their difference over 2 + F is the logarithm of the odds.
    """
    error = gap * (settings.plain_form if plain else settings.shaped_form)
    return error if distance is None else min(error, 0.5 * settings.along**2 * distance + 2 * settings.across * gap)


def compare(
    data: FitData,
    null: CandidateFit,
    fits: Sequence[CandidateFit] = (),
    distance: Callable[[CandidateFit, CandidateFit], float] | None = None,
    chance: Callable[[CandidateFit, CandidateFit], float] | None = None,
    settings: RankingSettings = RANKING,
) -> ModelComparison:
    """Compare fits of a log.

    Args:
        data: Log and weights.
        null: The nominal model, with what is tolerated fitted.
        fits: All other fits.
        distance: Sum of the squares by which the weighted prediction errors of two fits differ; None where not known.
        chance: What the sums of squares of two fits may differ by without evidence [1]; None where not known.
        settings: Thresholds and costs.
    """
    noise, servos = data.record.premises.floor_is_noise, data.record.command is not None
    exact = noise and not null.predictor.tolerance.names
    return ModelComparison(
        null=null,
        fits=tuple(fits),
        n_values=data.n_values,
        floor_error=data.floor_error,
        noise_level=data.noise_level,
        rounding=float(data.measurement.rounding @ data.values_of_motors) / data.n_values,
        exact=exact,
        distance=distance,
        chance=None if noise or servos else chance,  # numbers of servos have common factors of their own
        settings=settings,
    )


def allowing_for_doubt(comparison: ModelComparison, data: FitData) -> ModelComparison:
    """Allow for a noise variance that is a little other than declared: alone it is no gap."""
    spread = float(np.hypot(comparison.floor_error, data.measurement.doubt))
    return replace(comparison, floor_error=spread)
