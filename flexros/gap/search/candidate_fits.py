"""The search for causes: every effect at every place against "nothing", then pairs, each fitted to the log."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flexros.effects.kinds.tool_error import AbstractToolError
from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import scales_of
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.estimates import placed
from flexros.gap.fit.least_squares import EXACTLY, CandidateFit, Linearised, best_of, chi2_of, fit, linearise, starts_of
from flexros.gap.fit.pruning import without_least_number
from flexros.gap.fit.screening import promises
from flexros.gap.fit.tolerance_takeover import with_relief
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.search.harmonic_candidates import harmonic_candidates, other_orders

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.candidate import Candidate, Hypothesis
    from flexros.gap.candidates.scales import Scales
    from flexros.gap.residuals.fit_data import FitData

FALLING = 0.5
"""A fit goes on as long as some iterations lower its sum of squares to less than this share (chosen)."""
Item = TypeVar("Item")
Result = TypeVar("Result")
NULL, FEW, SOME, MANY = 60, 4, 5, 20
"""Iterations of the fit of the nominal model; of others at first, of several together, and of the best (chosen)."""
SETTLED = 3
"""A fit that needs no more iterations than this needs no second start (chosen)."""
FINISHED = 6
"""Fits that are carried to their end (chosen)."""
SECONDS = 5
"""Effects that are fitted beside each of them: those that promise most to linear theory (chosen)."""


@dataclass(eq=False)
class Search:
    """Searches one log.

    Attributes:
        model: The nominal model.
        data: Log and weights.
        tolerance: Numbers of the robot that are known with a tolerance only.
        progress: Called with the name of the stage and the share of it that is done.
        threads: Fits at the same time.
        tolerance_slopes: Derivatives of the prediction errors of the nominal model to its tolerated deviations, from
            the fit of single effects on, shape (n_values, n_tolerated); None where nothing is tolerated.
    """

    model: RobotWithEffects
    data: FitData
    tolerance: Tolerance = field(default_factory=Tolerance)
    progress: Callable[[str, float], None] | None = None
    threads: int = field(default_factory=lambda: os.cpu_count() or 1)
    tolerance_slopes: FloatArray | None = None
    _distances: dict[frozenset[CandidateFit], float] = field(default_factory=dict, init=False, repr=False)

    def predictor(self, hypothesis: Hypothesis) -> Predictor:
        """Build the predictor of a hypothesis for this log."""
        record = self.data.record
        return Predictor(
            self.model, hypothesis, self.tolerance, record.sample_time, measured_torque=record.measured_torque
        )

    def nothing(self) -> CandidateFit:
        """Fit the nominal model; what moves is what is known with a tolerance only.

        The frame of a tool tracker is estimated again with it, which the data of the search have from then on.
        """
        predictor = self.predictor(())
        found = fit(predictor, self.data, np.zeros(predictor.n_fitted), NULL)
        if self.data.tool is None or not predictor.n_fitted:
            return found
        self.data = self.data.tool_seen_by(predictor, found.theta)
        return fit(predictor, self.data, found.theta, NULL)

    def states(self, found: CandidateFit) -> FloatArray:
        """Predict the states of a fitted hypothesis, shape (n, n_states)."""
        prediction = self.data.predict(found.predictor, found.theta[:, None], record_states=True)
        assert prediction.states is not None
        states: FloatArray = prediction.states[:, :, 0].copy()
        return states

    def residual(self, found: CandidateFit) -> FloatArray:
        """Weigh the prediction errors of a fitted hypothesis, shape (M n,)."""
        residual: FloatArray = self.data.residuals(found.predictor, found.theta[:, None])[:, 0].copy()
        return residual

    def distance(self, one: CandidateFit, other: CandidateFit) -> float:
        """Return the sum of the squares by which the weighted prediction errors of two fits differ [1]."""
        pair = frozenset((one, other))
        if pair not in self._distances:
            self._distances[pair] = float(np.sum((self.residual(one) - self.residual(other)) ** 2))
        return self._distances[pair]

    def scales(self, found: CandidateFit) -> Scales:
        """Take the largest torques, speeds and deflections from the log."""
        return scales_of(self.model.robot, self.states(found), self.data.record.torque)

    def candidates(self, sizes: Scales) -> tuple[Candidate, ...]:
        """List what may be there by ranges: all but what repeats with the turning of a rotor.

        Args:
            sizes: Largest torques, speeds and deflections of the log.
        """
        tool = self.data.tool is not None
        among = list_candidates(self.model.robot, sizes)
        return tuple(one for one in among if tool or not issubclass(one.effect, AbstractToolError))

    def waves(self, found: CandidateFit) -> tuple[Candidate, ...]:
        """List what may be there by the orders of rotors that the errors of what was found repeat with.

        Args:
            found: What was found.
        """
        return harmonic_candidates(self.model.robot, self.data, self.residual(found), self.states(found))

    def singles(self, nothing: CandidateFit, among: Sequence[Candidate]) -> list[CandidateFit]:
        """Fit every candidate alone: all for a few iterations, the best ones to the end.

        An effect that extends simpler ones starts from their fits, and only where one of those is worth anything.

        Args:
            nothing: The fitted nominal model.
            among: The candidates.

        Returns:
            Fits, the best first.
        """
        deviations = nothing.theta[nothing.predictor.n_effect :]
        if len(deviations):
            self.tolerance_slopes = linearise(nothing.predictor, self.data, nothing.theta).slopes

        def one(candidate: Candidate) -> CandidateFit:
            predictor = self.predictor((candidate,))
            starts = starts_of(predictor)
            starts[predictor.n_effect :] = deviations[:, None]
            return self._from_grid(predictor, starts)

        found = self._parallel(
            "single effects", one, [candidate for candidate in among if not candidate.effect.extends]
        )
        worth = float(np.log(self.data.n_values))
        simple = [fitted for fitted in found if nothing.chi2 - fitted.chi2 > worth]
        pairs = [(candidate, fitted) for candidate in among for fitted in simple if _extends(candidate, fitted)]
        found += self._parallel("richer effects", lambda pair: self._extended(*pair), pairs)
        return self._visible(self._finished(found))

    def _visible(self, found: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Leave out fits of rich effects that are no more than a simpler one, which is fitted as well."""
        robot = self.model.robot
        noise = dict(zip(robot.joint_names, robot.encoder_noise))
        least = float(robot.encoder_noise.min())
        return [one for one in found if all(put.effect.visible(noise.get(put.location, least)) for put in placed(one))]

    def _extended(self, candidate: Candidate, simple: CandidateFit) -> CandidateFit:
        """Fit an effect from the numbers of a simpler one that it contains."""
        values = simple.predictor.values(simple.theta)[0]
        shared = candidate.effect.extends[simple.predictor.hypothesis[0].effect.name]
        predictor = self.predictor((candidate,))
        starts = starts_of(predictor)
        for number, free in enumerate(candidate.free):
            if free.name in shared:
                starts[number] = free.encode(values[shared[free.name]])
        starts[predictor.n_effect :] = simple.theta[simple.predictor.n_effect :, None]
        return self._from_grid(predictor, np.unique(starts, axis=1))

    def _from_grid(self, predictor: Predictor, starts: FloatArray) -> CandidateFit:
        """Fit from the best start for a few iterations, and from the second best where it is not far worse."""
        sums = chi2_of(predictor, self.data, starts)
        order = np.argsort(sums)[:2]
        first = self._fallen(predictor, starts[:, order[0]], sums[order[0]])
        if len(order) < 2 or (first.converged and first.iterations <= SETTLED):
            return first
        return best_of([first, self._fallen(predictor, starts[:, order[1]], sums[order[1]])])

    def _fallen(self, predictor: Predictor, start: FloatArray, before: float) -> CandidateFit:
        """Fit for a few iterations, and on while the sum of squares falls steeply: it says nothing yet of its end."""
        one = self._quick(predictor, start)
        for _ in range(MANY // FEW):
            if one.converged or not one.chi2 < FALLING * before:
                break
            before, one = one.chi2, self._quick(predictor, one.theta)
        return one

    def _finished(self, found: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Carry the best fits to their end, those after the first one as long as there is hope."""
        ranked = sorted(found, key=lambda one: one.chi2)
        best = [self._continued(one, np.inf) for one in ranked[:1]]
        rival = min((one.chi2 for one in best), default=np.inf)
        best += self._parallel("best effects", lambda one: self._continued(one, rival), ranked[1:FINISHED])
        return sorted([*best, *ranked[FINISHED:]], key=lambda one: one.chi2)

    def _quick(self, predictor: Predictor, start: FloatArray) -> CandidateFit:
        """Fit for a few iterations, with derivatives to tolerated deviations as they are without effects."""
        return fit(predictor, self.data, start, FEW, self.tolerance_slopes)

    def _continued(self, one: CandidateFit, rival: float) -> CandidateFit:
        """Carry a fit to its end, from the best order of a rotor near its own."""
        starts = other_orders(one, self.data.record)
        if starts.shape[1]:
            nearest = np.argsort(chi2_of(one.predictor, self.data, starts))[:2]
            one = best_of([one, *(self._quick(one.predictor, starts[:, place]) for place in nearest)])
        return fit(one.predictor, self.data, one.theta, MANY, enough=EXACTLY, rival=rival)

    def lean(self, one: CandidateFit) -> CandidateFit:
        """Leave out the numbers of a fit that are not worth their price by the information criterion (Schwarz 1978).

        Args:
            one: The fit.

        Returns:
            A fit of the same effects with fewer numbers, or the same fit.
        """
        n = self.data.n_values
        while (less := without_least_number(one)) is not None:
            leaner = fit(self.predictor(less[0]), self.data, less[1], MANY, enough=EXACTLY)
            if not n * np.log(leaner.chi2 / one.chi2) < np.log(n):
                break
            one = leaner
        return one

    def beside(self, firsts: Sequence[CandidateFit], nothing: CandidateFit, sizes: Scales) -> list[CandidateFit]:
        """Fit the most promising candidates beside each of some explanations.

        Args:
            firsts: Fitted explanations, the best first.
            nothing: The fitted nominal model.
            sizes: Largest torques, speeds and deflections of the log.

        Returns:
            Fits of each together with another candidate, the best first.
        """
        lines = [linearise(first.predictor, self.data, first.theta) for first in firsts]
        plain = self.residual(nothing)
        among: list[tuple[Candidate, int | None]] = [
            (candidate, place) for place, first in enumerate(firsts) for candidate in self.waves(first)
        ]
        among += [(candidate, None) for candidate in self.candidates(sizes)]
        screened = self._parallel("further effects", lambda pair: self._promises(pair[0], nothing, plain, lines), among)
        pairs: list[tuple[CandidateFit, Candidate, FloatArray]] = []
        for place, first in enumerate(firsts):
            options = [
                (candidate, *with_relief(candidate, first, *found[place]))
                for (candidate, only), found in zip(among, screened)
                if only in (None, place) and candidate.name not in first.names
            ]
            options.sort(key=lambda option: -option[1])
            pairs += [(first, candidate, theta) for candidate, _, theta in options[:SECONDS]]
        return self._visible(
            self._finished(self._parallel("effects together", lambda pair: self._together(*pair), pairs))
        )

    def _promises(
        self, candidate: Candidate, nothing: CandidateFit, plain: FloatArray, lines: Sequence[Linearised]
    ) -> list[tuple[float, FloatArray]]:
        """Estimate what a candidate gains beside other effects, and where to start."""
        predictor = self.predictor((candidate,))
        starts = starts_of(predictor)
        starts[predictor.n_effect :] = nothing.theta[nothing.predictor.n_effect :, None]
        return promises(predictor, self.data, starts, plain, lines)

    def _together(self, first: CandidateFit, candidate: Candidate, theta: FloatArray) -> CandidateFit:
        """Fit an explanation together with another candidate."""
        predictor = self.predictor((*first.predictor.hypothesis, candidate))
        return fit(predictor, self.data, theta, SOME, self.tolerance_slopes)

    def _parallel(self, stage: str, work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
        results: list[Result] = []
        with ThreadPoolExecutor(self.threads) as pool:
            for done, result in enumerate(pool.map(work, items), 1):
                results.append(result)
                if self.progress is not None:
                    self.progress(stage, done / len(items))
        return results


def _extends(candidate: Candidate, simple: CandidateFit) -> bool:
    """Tell whether an effect contains another one, at the same place."""
    other = simple.predictor.hypothesis[0]
    return other.effect.name in candidate.effect.extends and other.location == candidate.location
