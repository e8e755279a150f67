"""Refits of an explanation: with further effects, without some of them, with other parameters free."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.candidate_fit import best_of
from flexros.gap.fit.initial_values import starts_of
from flexros.gap.fit.linearisation import linearise
from flexros.gap.fit.screening import surroundings_of
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.prediction.compiled_plant import LANES
from flexros.gap.search.fits.log_fits import LogFits
from flexros.prediction.integration_step import is_finer

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Candidate, Hypothesis
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.screening import Surroundings
    from flexros.gap.prediction.compiled_plant import CompiledPlant
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.search.fits.additions import Addition

REMEMBERED = 2
"""Explanations whose linearisation is kept (chosen): each has the size of some predictions."""
NEAR = 2.0
"""Sum of squares over that of noise below which further effects hardly move tolerated numbers [1] (chosen)."""
REFINED = 4
"""Rounds in which the parameters of a law in place of a curve are refined alone (chosen)."""
BESIDE = (0.97, 0.985, 1.015, 1.03)
"""Factors of a size from which a law whose torque jumps is fitted again (chosen)."""
HOPS = 4
"""Most rounds of such fits (chosen)."""
PROMISES = 0.02
"""Fall of the sum of squares, over it, by which each of these fits must be better [1] (chosen)."""
RICH_STARTS = 2 * LANES
"""Most initial values of the further parameters of a rich law (chosen)."""


@dataclass(frozen=True, eq=False)
class _Around:
    """A fit, linearised.

    Attributes:
        fit: The fit.
        tolerance_slopes: Derivatives of the weighted prediction errors to the tolerated deviations, shape (n_values,
            n_tolerated).
        surroundings: The fit, linearised on the rows of the search.
        removals: The same without each of its effects; empty until they are asked for.
    """

    fit: CandidateFit
    tolerance_slopes: FloatArray
    surroundings: Surroundings
    removals: list[Surroundings] = field(default_factory=list)


@dataclass(frozen=True, eq=False, kw_only=True)
class Refits(LogFits):
    """Fits of explanations that were fitted with other effects or parameters; see `LogFits`."""

    _linearised: list[_Around] = field(init=False, default_factory=list)

    def surroundings(self, fit: CandidateFit) -> Surroundings:
        """Linearise a fit on the rows of the search.

        Steps that look at the same explanation one after the other share the result: elimination, growth, exchange.
        """
        known = self._around(fit)
        if known is None:
            line = linearise(fit.predictor, self.data, fit.theta)
            slopes = line.slopes[:, fit.predictor.n_effect :].copy(order="F")
            known = _Around(fit, slopes, surroundings_of(fit, line, self.rows, self.data.misfit))
            self._linearised[:] = [known, *self._linearised[: REMEMBERED - 1]]
        return known.surroundings

    def _around(self, fit: CandidateFit) -> _Around | None:
        """Return what is known around a fit; None where it was not linearised yet."""
        return next((one for one in self._linearised if one.fit is fit), None)

    def _slopes_around(self, fit: CandidateFit, predictor: Predictor) -> FloatArray | None:
        """Return the derivatives to the tolerated deviations around a fit; None where they are not known.

        Args:
            fit: The fit.
            predictor: Of another hypothesis, whose tolerated numbers must be the same.
        """
        around = self._around(fit)
        alike = predictor.tolerance.deviations == fit.predictor.tolerance.deviations
        return around.tolerance_slopes if around is not None and alike else None

    def together(
        self,
        fit: CandidateFit,
        additions: Sequence[Addition],
        without: Collection[str] = (),
        plant: CompiledPlant | None = None,
        rival: float = np.inf,
    ) -> CandidateFit:
        """Fit an explanation together with further candidates.

        Derivatives to tolerated numbers stay those around the explanation, if known, where the candidates replace
        others or the explanation leaves little more than noise.

        Args:
            fit: The explanation.
            additions: The candidates.
            without: Names of those of its own candidates that they replace, effect@location.
            plant: A plant that may hold all of them already.
            rival: Sum of squares of a better fit: this one ends where it has no hope to come near it.
        """
        rest = tuple(candidate for candidate in fit.hypothesis if candidate.name not in without)
        own = fit.theta[: fit.predictor.n_effect][~fit.columns(without)[: fit.predictor.n_effect]]
        replaced = np.any([addition.replaced for addition in additions], axis=0)
        deviations = fit.predictor.tolerance.without(fit.deviations, replaced)
        theta = np.concatenate([own, *(addition.start for addition in additions), deviations])
        predictor = self.null.predictor((*rest, *(addition.candidate for addition in additions)), plant)
        near = bool(without) or fit.chi2 < NEAR * self.data.n_values
        slopes = self._slopes_around(fit, predictor) if near else None
        fit = self._joint(predictor, theta, rival=rival, slopes=slopes)
        harmonic = any(addition.candidate.effect.harmonics for addition in additions)
        return self._near_best_order(fit) if harmonic else fit

    def without(self, fit: CandidateFit, *names: str) -> CandidateFit:
        """Fit an explanation without some of its candidates.

        A candidate with fast states needs finer integration steps, and what these improve is not its merit: an effect
        of no size would gain hundreds of nats by them. So they are kept where they matter.

        Derivatives to tolerated numbers stay those around the explanation where they are known.

        Args:
            fit: The explanation.
            names: Names of the candidates, effect@location.
        """
        rest = tuple(candidate for candidate in fit.hypothesis if candidate.name not in names)
        predictor, theta = self.null.predictor(rest, fit.predictor.plant), fit.theta[~fit.columns(names)]
        if is_finer(fit.predictor.plant.steps, predictor.plant.steps):
            with_same_steps = float(chi2_of(fit.predictor, self.data, fit.switched_off(names)[:, None])[0])
            with_fewer = float(chi2_of(predictor, self.data, theta[:, None])[0])
            if not abs(with_fewer - with_same_steps) < np.log(self.data.n_values):
                predictor = self.null.predictor(rest, self.null.plant(rest, steps=fit.predictor.plant.steps))
        return self._joint(predictor, theta, finishing=True, slopes=self._slopes_around(fit, predictor))

    def with_nominal_numbers(self, fit: CandidateFit) -> CandidateFit:
        """Return a fit with the tolerated numbers of the model at their nominal values, not fitted again."""
        theta = fit.theta.copy()
        theta[fit.predictor.n_effect :] = 0.0
        return replace(fit, theta=theta, chi2=float(chi2_of(fit.predictor, self.data, theta[:, None])[0]))

    def reshaped(self, fit: CandidateFit, hypothesis: Hypothesis) -> CandidateFit:
        """Fit the effects of an explanation with other parameters free, from its values.

        New ones begin at zero where they may be negative, else at their first initial value.

        Args:
            fit: The explanation.
            hypothesis: The same effects, in the same order, each with as many free parameters or other ones.
        """
        sizes = [
            free.encode(values.get(free.name, 0.0 if free.signed else free.starts[0]))
            for candidate, values in zip(hypothesis, fit.predictor.values(fit.theta), strict=True)
            for free in candidate.free
        ]
        predictor = self.null.predictor(hypothesis, fit.predictor.plant)
        return self._joint(predictor, np.concatenate([sizes, fit.deviations]))

    def enriched(
        self, fit: CandidateFit, one: Candidate, rich: Candidate, plant: CompiledPlant, least: float
    ) -> CandidateFit | None:
        """Fit an explanation with a rich law in place of one that it contains, begun with the values of that.

        Args:
            fit: The explanation.
            one: The law that is replaced.
            rich: The law that contains it.
            plant: A plant that holds all laws.
            least: Fall of the sum of squares that an initial value of the further parameters must bring at once [1].

        Returns:
            A fit that is not carried to its end; None where no initial value does that the encoder shows, and for a law
            that takes away what the model has.
        """
        laws = zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True)
        values = next(values for law, values in laws if law is one)
        placed = one.placed(values).effect  # with its usual value where a parameter is not free
        known = {name: getattr(placed, simple) for name, simple in rich.effect.extends[one.effect.name].items()}
        if any(known.get(free.name, 0.0) < 0 for free in rich.free if not free.signed):
            return None
        return self.in_place(fit, one, rich, plant, fit.chi2 - least, known)

    def in_place(
        self,
        fit: CandidateFit,
        one: Candidate,
        other: Candidate,
        plant: CompiledPlant,
        most: float,
        known: Mapping[str, float] = MappingProxyType({}),
        *,
        refined: bool = False,
    ) -> CandidateFit | None:
        """Fit an explanation with another law in place of one, begun with all others as they are.

        Args:
            fit: The explanation.
            one: The law that is replaced.
            other: The other law.
            plant: A plant that holds all laws.
            most: Sum of squares below which an initial value of the other law must come at once [1].
            known: Parameters of the other law that are known.
            refined: Whether the best initial values are refined alone first: where all sizes move at once, those of
                others leave the valley in which they are right.

        Returns:
            A fit that is not carried to its end; None where no initial value does that the encoder shows.
        """
        own = starts_of((other,), RICH_STARTS)
        for index, free in enumerate(other.free):
            if free.name in known:
                own[index] = free.encode(known[free.name])
        own = np.unique(own, axis=1)
        before, n_effect = fit.columns((one.name,)), fit.predictor.n_effect
        others, deviations = np.split(np.repeat(fit.theta[:, None], own.shape[1], axis=1), [n_effect])
        starts = np.vstack([others[~before[:n_effect]], own, deviations])
        predictor = self.null.predictor((*(law for law in fit.hypothesis if law is not one), other), plant)
        shown = [self.shows(other.placed(predictor.values(column)[-1])) for column in starts.T]
        starts = starts[:, shown]
        if not starts.size:
            return None
        sums = chi2_of(predictor, self.data, starts)
        best = int(np.argmin(sums))
        if not sums[best] < most:
            return None
        start = starts[:, best]
        if refined:
            first = int((~before[:n_effect]).sum())
            start = self._refined(predictor, start, range(first, first + len(own)))
        return self._joint(predictor, start)

    def beside_jumps(self, fit: CandidateFit) -> CandidateFit:
        """Fit an explanation again from sizes near its own of laws whose torque jumps, such as backlash.

        Each impact moves when a gap becomes wider, so that the sum of squares has minima beside the lowest one: of two
        axes with five effects, a gap had ended 2.3 % too small and a load 6 %, for which a weight stood then.

        Args:
            fit: The explanation.

        Returns:
            The best fit of the same parameters.
        """
        laws = [one.effect.jumps for one in fit.hypothesis for _ in one.free]
        pairs = [(column, factor) for column, jumps in enumerate(laws) if jumps for factor in BESIDE]

        def beside(pair: tuple[int, float], begun: CandidateFit) -> CandidateFit:
            column, factor = pair
            start, (low, high) = begun.theta.copy(), begun.predictor.bounds
            start[column] = np.clip(start[column] + np.log(factor), low[column], high[column])
            return self._quick(begun.predictor, start)

        for _ in range(HOPS):
            if not pairs or self.deadline.stops_finishing():
                break
            best = best_of([fit, *self.parallel("sizes nearby", partial(beside, begun=fit), pairs)])
            if not best.chi2 < (1 - PROMISES) * fit.chi2:
                break
            fit = self._final(best.predictor, best.theta)
        return fit

    def _refined(self, predictor: Predictor, start: FloatArray, columns: range) -> FloatArray:
        """Refine some parameters of a fit one after the other, with all others as they are.

        Args:
            predictor: The predictor.
            start: Parameters in the units of the fit, shape (n_fitted,).
            columns: Those that are refined.
        """
        low, high = predictor.bounds
        steps = {column: (high[column] - low[column]) / LANES for column in columns}
        for _ in range(REFINED):
            for column in columns:
                group = np.repeat(start[:, None], LANES, axis=1)
                around = steps[column] * np.linspace(-1, 1, LANES)
                group[column] = np.clip(start[column] + around, low[column], high[column])
                group[:, 0] = start
                start = group[:, int(np.argmin(chi2_of(predictor, self.data, group)))]
                steps[column] *= 3 / LANES
        return start
