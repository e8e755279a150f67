"""Fits of candidates to one log: each alone, then in addition to the best explanations."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flexros.effects import effects
from flexros.effects.kinds.tool_error import AbstractToolError
from flexros.errors import unknown_name
from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import scales_of
from flexros.gap.fit.estimates import placed_effects
from flexros.gap.fit.least_squares import CandidateFit, Linearised, best_of, chi2_of, initial_values, linearise
from flexros.gap.fit.least_squares import fit as fit_candidate
from flexros.gap.fit.pruning import without_least_parameter
from flexros.gap.fit.screening import predicted_gains
from flexros.gap.fit.tolerance_takeover import with_takeover
from flexros.gap.search.harmonic_candidates import harmonic_candidates, neighbouring_orders
from flexros.gap.settings import DiagnosisSettings

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import AbstractEffect
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.candidates.scales import Scales
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData

Item = TypeVar("Item")
Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Search:
    """The common ground of all fits of candidates to one log.

    Attributes:
        null: The fitted nominal model, with log and weights.
        null_residual: Its weighted prediction errors, shape (n_values,).
        tolerance_slopes: Derivatives of these errors to the tolerated deviations, shape (n_values, n_tolerated); None
            where nothing is tolerated.
        scales: Largest torques, speeds and deflections of the log.
        distance: Sum of the squares by which the weighted prediction errors of two fits differ.
        settings: Settings of the diagnosis.
        threads: Fits at the same time.
        progress: Called with the name of a step and the share of it that is done.
    """

    null: NullFit
    null_residual: FloatArray
    tolerance_slopes: FloatArray | None
    scales: Scales
    distance: Callable[[CandidateFit, CandidateFit], float]
    settings: DiagnosisSettings
    threads: int
    progress: Callable[[str, float], None] | None = None

    @property
    def data(self) -> FitData:
        """Log and weights."""
        return self.null.data

    def candidates(self) -> tuple[Candidate, ...]:
        """List the candidates that come from the ranges of effects; those of harmonics follow from a fit."""
        tool = self.data.tool is not None
        return tuple(
            candidate
            for candidate in list_candidates(self.null.model.robot, self.scales)
            if self._competes(candidate.effect) and (tool or not issubclass(candidate.effect, AbstractToolError))
        )

    def harmonics(self, fit: CandidateFit) -> tuple[Candidate, ...]:
        """List the candidates with the orders of the rotors at which the residuals of a fit repeat."""
        if not any(self._competes(effect) for effect in effects().values() if effect.harmonics):
            return ()
        robot, settings = self.null.model.robot, self.settings.search
        found = harmonic_candidates(robot, self.data, fit.residual(self.data), fit.states(self.data), settings)
        return tuple(candidate for candidate in found if self._competes(candidate.effect))

    def _competes(self, effect: type[AbstractEffect]) -> bool:
        return not self.settings.search.effects or effect.name in self.settings.search.effects

    def singles(self, candidates: Sequence[Candidate]) -> list[CandidateFit]:
        """Fit every candidate alone: all for a few iterations, the best ones to the end.

        An effect that extends simpler ones starts from their fits, and only where one of those gains anything.

        Args:
            candidates: The candidates.

        Returns:
            Fits, the best first.
        """
        simple = [candidate for candidate in candidates if not candidate.effect.extends]
        fits = self._parallel("single effects", self._single, simple)
        worth = float(np.log(self.data.n_values))
        gaining = [fit for fit in fits if self.null.fit.chi2 - fit.chi2 > worth]
        pairs = [(candidate, fit) for candidate in candidates for fit in gaining if _extends(candidate, fit)]
        fits += self._parallel("richer effects", lambda pair: self._extended(*pair), pairs)
        return self._visible(self._finished(fits))

    def _single(self, candidate: Candidate) -> CandidateFit:
        """Fit a candidate from its own initial values."""
        predictor = self.null.predictor((candidate,))
        starts = initial_values(predictor, self.settings.fit.most_starts)
        starts[predictor.n_effect :] = self.null.fit.deviations[:, None]
        return self._from_grid(predictor, starts)

    def _extended(self, candidate: Candidate, simple: CandidateFit) -> CandidateFit:
        """Fit a candidate from the parameters of a simpler effect that it contains."""
        values = simple.predictor.values(simple.theta)[0]
        shared = candidate.effect.extends[simple.hypothesis[0].effect.name]
        predictor = self.null.predictor((candidate,))
        starts = initial_values(predictor, self.settings.fit.most_starts)
        for index, free in enumerate(candidate.free):
            if free.name in shared:
                starts[index] = free.encode(values[shared[free.name]])
        starts[predictor.n_effect :] = simple.deviations[:, None]
        return self._from_grid(predictor, np.unique(starts, axis=1))

    def _from_grid(self, predictor: Predictor, starts: FloatArray) -> CandidateFit:
        """Fit from the best initial value, and from the second best unless that converges at once."""
        sums = chi2_of(predictor, self.data, starts)
        order = np.argsort(sums)[:2]
        best = self._while_steep(predictor, starts[:, order[0]], sums[order[0]])
        if len(order) < 2 or (best.converged and best.iterations <= self.settings.search.settled):
            return best
        return best_of([best, self._while_steep(predictor, starts[:, order[1]], sums[order[1]])])

    def _while_steep(self, predictor: Predictor, start: FloatArray, chi2: float) -> CandidateFit:
        """Fit for a few iterations, and on while the sum of squares falls steeply, as its minimum is still unknown."""
        fit = self._quick(predictor, start)
        for _ in range(self.settings.fit.final_iterations // self.settings.fit.first_iterations):
            if fit.converged or not fit.chi2 < self.settings.search.steep * chi2:
                break
            chi2, fit = fit.chi2, self._quick(predictor, fit.theta)
        return fit

    def _quick(self, predictor: Predictor, start: FloatArray) -> CandidateFit:
        """Fit for a few iterations, with the tolerance slopes of the nominal model."""
        return self._fit(predictor, start, self.settings.fit.first_iterations, quick=True)

    def _fit(
        self, predictor: Predictor, start: FloatArray, iterations: int, *, quick: bool = False, rival: float = np.inf
    ) -> CandidateFit:
        """Fit, quickly with the tolerance slopes of the nominal model or exactly with its own."""
        settings = self.settings.fit
        slopes, enough = (self.tolerance_slopes, settings.enough) if quick else (None, settings.exactly)
        return fit_candidate(
            predictor,
            self.data,
            start,
            iterations,
            tolerance_slopes=slopes,
            enough=enough,
            rival=rival,
            settings=settings,
        )

    def _visible(self, fits: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Leave out fits of rich effects that are no more than a simpler one, which is fitted as well."""
        robot = self.null.model.robot
        noise = dict(zip(robot.joint_names, robot.encoder_noise))
        least = float(robot.encoder_noise.min())
        return [
            fit
            for fit in fits
            if all(placed.effect.visible(noise.get(placed.location, least)) for placed in placed_effects(fit))
        ]

    def _finished(self, fits: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Carry the best fits to their end, those after the first one as long as they may still come near it."""
        finished = self.settings.search.finished
        ranked = sorted(fits, key=lambda fit: fit.chi2)
        best = [self._continued(fit, np.inf) for fit in ranked[:1]]
        rival = min((fit.chi2 for fit in best), default=np.inf)
        best += self._parallel("best effects", lambda fit: self._continued(fit, rival), ranked[1:finished])
        return sorted([*best, *ranked[finished:]], key=lambda fit: fit.chi2)

    def _continued(self, fit: CandidateFit, rival: float) -> CandidateFit:
        """Carry a fit to its end, from the best order of a rotor near its own."""
        starts = neighbouring_orders(fit, self.data.record)
        if starts.shape[1]:
            nearest = np.argsort(chi2_of(fit.predictor, self.data, starts))[:2]
            fit = best_of([fit, *(self._quick(fit.predictor, starts[:, index]) for index in nearest)])
        return self._fit(fit.predictor, fit.theta, self.settings.fit.final_iterations, rival=rival)

    def pruned(self, fit: CandidateFit) -> CandidateFit:
        """Leave out the parameters of a fit that the information criterion rejects (Schwarz 1978).

        Args:
            fit: The fit.

        Returns:
            A fit of the same effects with fewer parameters, or the same fit.
        """
        n = self.data.n_values
        while (fewer := without_least_parameter(fit)) is not None:
            hypothesis, theta = fewer
            pruned = self._fit(self.null.predictor(hypothesis), theta, self.settings.fit.final_iterations)
            if not n * np.log(pruned.chi2 / fit.chi2) < np.log(n):
                break
            fit = pruned
        return fit

    def extended(self, explanations: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Fit the most promising candidates in addition to each of some explanations.

        Args:
            explanations: Fitted explanations, the best first.

        Returns:
            Fits of each together with one more candidate, the best first.
        """
        lines = [linearise(fit.predictor, self.data, fit.theta) for fit in explanations]
        candidates: list[tuple[Candidate, int | None]] = [
            (candidate, index) for index, fit in enumerate(explanations) for candidate in self.harmonics(fit)
        ]
        candidates += [(candidate, None) for candidate in self.candidates()]
        gains = self._parallel("further effects", lambda pair: self._predicted_gains(pair[0], lines), candidates)
        pairs: list[tuple[CandidateFit, Candidate, FloatArray]] = []
        for index, fit in enumerate(explanations):
            options = [
                (candidate, *with_takeover(candidate, fit, *gain[index]))
                for (candidate, only), gain in zip(candidates, gains)
                if only in (None, index) and candidate.name not in fit.names
            ]
            options.sort(key=lambda option: -option[1])
            pairs += [(fit, candidate, theta) for candidate, _, theta in options[: self.settings.search.added]]
        fits = self._parallel("effects together", lambda pair: self._together(*pair), pairs)
        return self._visible(self._finished(fits))

    def _predicted_gains(self, candidate: Candidate, lines: Sequence[Linearised]) -> list[tuple[float, FloatArray]]:
        """Estimate what a candidate gains in addition to other effects, and its initial value."""
        predictor = self.null.predictor((candidate,))
        starts = initial_values(predictor, self.settings.fit.most_starts)
        starts[predictor.n_effect :] = self.null.fit.deviations[:, None]
        return predicted_gains(predictor, self.data, starts, self.null_residual, lines)

    def _together(self, explanation: CandidateFit, candidate: Candidate, theta: FloatArray) -> CandidateFit:
        """Fit an explanation together with one more candidate."""
        predictor = self.null.predictor((*explanation.hypothesis, candidate))
        return self._fit(predictor, theta, self.settings.fit.joint_iterations, quick=True)

    def _parallel(self, step: str, work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
        results: list[Result] = []
        with ThreadPoolExecutor(self.threads) as pool:
            for done, result in enumerate(pool.map(work, items), 1):
                results.append(result)
                if self.progress is not None:
                    self.progress(step, done / len(items))
        return results


def prepare_search(
    null: NullFit, settings: DiagnosisSettings | None = None, progress: Callable[[str, float], None] | None = None
) -> Search:
    """Prepare the fits of candidates to one log.

    Args:
        null: The fitted nominal model.
        settings: Settings of the diagnosis.
        progress: Called with the name of a step and the share of it that is done.

    Raises:
        InputError: The settings name an effect that does not exist.
    """
    settings = settings or DiagnosisSettings()
    for name in settings.search.effects:
        if name not in effects():
            raise unknown_name("effect", name, effects(), "search.effects")
    data, fit = null.data, null.fit
    return Search(
        null=null,
        null_residual=fit.residual(data),
        tolerance_slopes=linearise(fit.predictor, data, fit.theta).slopes if len(fit.deviations) else None,
        scales=scales_of(null.model.robot, fit.states(data), data.record.torque),
        distance=_distances(data),
        settings=settings,
        threads=settings.threads or os.cpu_count() or 1,
        progress=progress,
    )


def _distances(data: FitData) -> Callable[[CandidateFit, CandidateFit], float]:
    """Return the function that computes the distance of two fits, and keeps it, as it costs two predictions."""
    known: dict[frozenset[CandidateFit], float] = {}

    def distance(fit: CandidateFit, other: CandidateFit) -> float:
        pair = frozenset((fit, other))
        if pair not in known:
            known[pair] = float(np.sum((fit.residual(data) - other.residual(data)) ** 2))
        return known[pair]

    return distance


def _extends(candidate: Candidate, simple: CandidateFit) -> bool:
    """Return whether a candidate contains the effect of a fit, at the same location."""
    other = simple.hypothesis[0]
    return other.effect.name in candidate.effect.extends and other.location == candidate.location
