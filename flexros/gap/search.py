"""The search for causes: every effect at every place against "nothing", then pairs, each fitted to the log."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flexros.effects.tool_error import AbstractToolError
from flexros.gap.fit import Fit, best_of, chi2_of, fit, linearise, starts_of
from flexros.gap.hypothesis import suspects
from flexros.gap.periodic_suspects import periodic_suspects
from flexros.gap.predictor import Predictor
from flexros.gap.tolerance import Tolerance
from flexros.gap.yardsticks import yardsticks

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.fit_data import FitData
    from flexros.gap.hypothesis import Hypothesis, Suspect
    from flexros.gap.yardsticks import Yardsticks

HUGE = 1e200
"""Sum of squared changes beyond which a start has run away [1]."""
Item = TypeVar("Item")
Result = TypeVar("Result")
FEW, MANY = 4, 20
"""Iterations of a fit at first, and where it is among the best (chosen)."""
SETTLED = 3
"""A fit that needs no more iterations than this needs no second start (chosen)."""
FINISHED = 8
"""Fits that are carried to their end (chosen)."""
FIRSTS = 3
"""Best single effects that others are added to (chosen)."""
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
    """

    model: RobotWithEffects
    data: FitData
    tolerance: Tolerance = field(default_factory=Tolerance)
    progress: Callable[[str, float], None] | None = None
    threads: int = field(default_factory=lambda: os.cpu_count() or 1)

    def predictor(self, hypothesis: Hypothesis) -> Predictor:
        """Build the predictor of a hypothesis for this log."""
        record = self.data.record
        return Predictor(
            self.model, hypothesis, self.tolerance, record.sample_time, measured_torque=record.measured_torque
        )

    def nothing(self) -> Fit:
        """Fit the nominal model; what moves is what is known with a tolerance only."""
        predictor = self.predictor(())
        start = np.zeros(predictor.n_fitted)
        return fit(predictor, self.data, start, 6)

    def states(self, found: Fit) -> FloatArray:
        """Predict the states of a fitted hypothesis, shape (n, n_states)."""
        prediction = found.predictor.predict(
            found.theta[:, None], self.data.record, self.data.gain, self.data.start, record_states=True
        )
        assert prediction.states is not None
        states: FloatArray = prediction.states[:, :, 0]
        return states

    def residual(self, found: Fit) -> FloatArray:
        """Weigh the prediction errors of a fitted hypothesis, shape (M n,)."""
        residual: FloatArray = self.data.residuals(found.predictor, found.theta[:, None])[:, 0]
        return residual

    def yardsticks(self, found: Fit) -> Yardsticks:
        """Take the largest torques, speeds and deflections from the log."""
        return yardsticks(self.model.robot, self.states(found), self.data.record.torque)

    def suspects(self, found: Fit, sizes: Yardsticks) -> tuple[Suspect, ...]:
        """List what may be there beside what was found: by ranges, and by orders that the errors repeat with."""
        held = {suspect.name for suspect in found.predictor.hypothesis}
        waves = periodic_suspects(self.model.robot, self.data, self.residual(found), self.states(found))
        among = (*suspects(self.model.robot, sizes), *waves)
        seen = [one for one in among if self.data.tool is not None or not issubclass(one.effect, AbstractToolError)]
        return tuple(one for one in seen if one.name not in held)

    def singles(self, nothing: Fit, among: Sequence[Suspect]) -> list[Fit]:
        """Fit every suspect alone: all for a few iterations, the best ones to the end.

        An effect that extends simpler ones starts from their fits, and only where one of those is worth anything.

        Args:
            nothing: The fitted nominal model.
            among: The suspects.

        Returns:
            Fits, the best first.
        """
        deviations = nothing.theta[nothing.predictor.n_effect :]

        def one(suspect: Suspect) -> Fit:
            predictor = self.predictor((suspect,))
            starts = starts_of(predictor)
            starts[predictor.n_effect :] = deviations[:, None]
            return self._from_grid(predictor, starts)

        found = self._parallel("single effects", one, [suspect for suspect in among if not suspect.effect.extends])
        worth = float(np.log(self.data.n_values))
        simple = [fitted for fitted in found if nothing.chi2 - fitted.chi2 > worth]
        pairs = [(suspect, fitted) for suspect in among for fitted in simple if _extends(suspect, fitted)]
        found += self._parallel("richer effects", lambda pair: self._extended(*pair), pairs)
        return self._finished(found)

    def _extended(self, suspect: Suspect, simple: Fit) -> Fit:
        """Fit an effect from the numbers of a simpler one that it contains."""
        values = simple.predictor.values(simple.theta)[0]
        shared = suspect.effect.extends[simple.predictor.hypothesis[0].effect.name]
        predictor = self.predictor((suspect,))
        starts = starts_of(predictor)
        for number, free in enumerate(suspect.free):
            if free.name in shared:
                starts[number] = free.encode(values[shared[free.name]])
        starts[predictor.n_effect :] = simple.theta[simple.predictor.n_effect :, None]
        return self._from_grid(predictor, starts)

    def _from_grid(self, predictor: Predictor, starts: FloatArray) -> Fit:
        """Fit from the best start for a few iterations, and from the second best where it is not far worse."""
        order = np.argsort(chi2_of(predictor, self.data, starts))[:2]
        first = fit(predictor, self.data, starts[:, order[0]], FEW)
        if len(order) < 2 or (first.converged and first.iterations <= SETTLED):
            return first
        return best_of([first, fit(predictor, self.data, starts[:, order[1]], FEW)])

    def _finished(self, found: Sequence[Fit]) -> list[Fit]:
        """Carry the best fits to their end."""
        ranked = sorted(found, key=lambda one: one.chi2)
        best = self._parallel("best effects", self._continued, ranked[:FINISHED])
        return sorted([*best, *ranked[FINISHED:]], key=lambda one: one.chi2)

    def _continued(self, one: Fit) -> Fit:
        return one if one.converged else fit(one.predictor, self.data, one.theta, MANY)

    def beside(self, first: Fit, sizes: Yardsticks) -> list[Fit]:
        """Fit every promising suspect beside what was found.

        Args:
            first: The fitted hypothesis.
            sizes: Largest torques, speeds and deflections of the log.

        Returns:
            Fits of both together, the best first.
        """
        residual, slopes = self.residual(first), directions(first, self.data)
        among = self.suspects(first, sizes)

        def promise(suspect: Suspect) -> tuple[float, Fit]:
            return self._promise(first, residual, slopes, suspect)

        screened = self._parallel("second effects", promise, among)
        screened.sort(key=lambda one: -one[0])

        def both(start: Fit) -> Fit:
            return fit(start.predictor, self.data, start.theta)

        fits = self._parallel("pairs", both, [start for _, start in screened[:SECONDS]])
        return sorted(fits, key=lambda one: one.chi2)

    def _promise(self, first: Fit, residual: FloatArray, slopes: FloatArray, suspect: Suspect) -> tuple[float, Fit]:
        """Estimate the fall of the sum of squares when a suspect is added, by linear theory, and where to start.

        Every start of the suspect gives a direction, how the errors change with it; the part of it that the fitted
        numbers cannot imitate is what counts.
        """
        predictor = self.predictor((*first.predictor.hypothesis, suspect))
        n_first = first.predictor.n_effect
        starts = starts_of(predictor, first.theta[:n_first])
        starts[predictor.n_effect :] = first.theta[n_first:, None]
        best, place = -np.inf, 0
        for begin in range(0, starts.shape[1], 8):
            errors = self.data.residuals(predictor, starts[:, begin : begin + 8])
            finite = np.all(np.isfinite(errors), axis=0)
            change = np.where(finite, errors, residual[:, None]) - residual[:, None]
            change -= (
                slopes @ np.linalg.lstsq(slopes.T @ slopes, slopes.T @ change, rcond=None)[0] if slopes.size else 0
            )
            along = -(residual @ change)
            length = np.einsum("ij,ij->j", change, change)
            gains = np.where((along > 0) & (length < HUGE), along**2 / np.maximum(length, 1e-12), 0.0)
            # a start that already lowers the sum counts for what it does, a far one for what its direction promises
            if gains.max() > best:
                best, place = float(gains.max()), begin + int(np.argmax(gains))
        return best, Fit(predictor, starts[:, place], np.inf)

    def _parallel(self, stage: str, work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
        results: list[Result] = []
        with ThreadPoolExecutor(self.threads) as pool:
            for done, result in enumerate(pool.map(work, items), 1):
                results.append(result)
                if self.progress is not None:
                    self.progress(stage, done / len(items))
        return results


def _extends(suspect: Suspect, simple: Fit) -> bool:
    """Tell whether an effect contains another one, at the same place."""
    other = simple.predictor.hypothesis[0]
    return other.effect.name in suspect.effect.extends and other.location == suspect.location


def directions(found: Fit, data: FitData) -> FloatArray:
    """Compute how the weighted prediction errors change with the fitted numbers.

    Args:
        found: A fitted hypothesis.
        data: Log and weights.

    Returns:
        Derivatives, shape (M n, n_fitted).
    """
    return linearise(found.predictor, data, found.theta).slopes
