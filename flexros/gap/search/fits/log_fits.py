"""How fits to one log are begun, carried on and ended: quickly for comparison, to their end where they count."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flexros.gap.deadline import Deadline
from flexros.gap.fit.candidate_fit import CandidateFit, best_of, best_of_each
from flexros.gap.fit.estimates import placed_effects
from flexros.gap.fit.least_squares import fit as fit_candidate
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.prediction.compiled_plant import LANES
from flexros.gap.search.model_probability import compare
from flexros.gap.search.periodic.harmonic_candidates import neighbouring_orders
from flexros.prediction.integration_step import is_finer

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.effects.kinds.base import PlacedEffect
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.settings import DiagnosisSettings
    from flexros.record.premises import Premises

Item = TypeVar("Item")
Result = TypeVar("Result")

WELL_BEFORE = 0.01
"""Fall of the sum of squares from which a fit had ended well before its end, over that sum [1] (chosen)."""


@dataclass(frozen=True, eq=False, kw_only=True)
class LogFits:
    """Fits to one log.

    Attributes:
        null: The fitted nominal model, with log and weights.
        tolerance_slopes: Derivatives of the weighted prediction errors to the tolerated deviations, shape (n_values,
            n_tolerated); None where nothing is tolerated.
        rows: Prediction errors that estimates of gains are computed from, evenly spread over the log, shape (n_rows,).
        settings: Settings of the diagnosis.
        threads: Fits at the same time.
        progress: Called with the name of a step and the share of it that is done.
        deadline: Asked between fits, and by them between iterations, whether to go on.
    """

    null: NullFit
    tolerance_slopes: FloatArray | None
    rows: IntArray
    settings: DiagnosisSettings
    threads: int
    progress: Callable[[str, float], None] | None = None
    deadline: Deadline = field(default_factory=Deadline)

    @property
    def data(self) -> FitData:
        """Log and weights."""
        return self.null.data

    @property
    def premises(self) -> Premises:
        """What is taken for granted of the log."""
        return self.data.record.premises

    def _from_grid(self, predictor: Predictor, starts: FloatArray, rival: float = np.inf) -> CandidateFit:
        """Fit from the best initial value, and from the second best unless that converges at once.

        A fit to a simulated log ends early where it has no hope to come near the sum of squares of a rival.
        """
        rival = rival if self.premises.floor_is_noise else np.inf
        sums = chi2_of(predictor, self.data, starts)
        order = np.argsort(sums)[:2]
        best = self._while_steep(predictor, starts[:, order[0]], sums[order[0]], rival)
        settled = best.converged and best.iterations <= self.settings.search.settled
        if len(order) < 2 or settled or self.deadline.stops():
            return best
        rival = min(rival, best.chi2) if self.premises.floor_is_noise else np.inf
        return best_of([best, self._while_steep(predictor, starts[:, order[1]], sums[order[1]], rival)])

    def _while_steep(self, predictor: Predictor, start: FloatArray, chi2: float, rival: float = np.inf) -> CandidateFit:
        """Fit for a few iterations, and on while the sum of squares falls steeply, as its minimum is still unknown."""
        fit = self._quick(predictor, start, rival)
        for _ in range(self.settings.fit.final_iterations // self.settings.fit.first_iterations):
            if fit.converged or not fit.chi2 < self.settings.search.steep * chi2 or self.deadline.stops():
                break
            chi2, fit = fit.chi2, self._quick(predictor, fit.theta, rival)
        return fit

    def _quick(self, predictor: Predictor, start: FloatArray, rival: float = np.inf) -> CandidateFit:
        """Fit for a few iterations, with the tolerance slopes of the nominal model."""
        return self._fit(predictor, start, self.settings.fit.first_iterations, quick=True, rival=rival)

    def _fit(
        self,
        predictor: Predictor,
        start: FloatArray,
        iterations: int,
        *,
        quick: bool = False,
        rival: float = np.inf,
        finishing: bool = False,
        held: FloatArray | None = None,
    ) -> CandidateFit:
        """Fit, quickly from the tolerance slopes of the nominal model on or exactly with its own.

        Those of a simulated log serve for the first step alone: the nominal model may lack so much that its tolerated
        deviations are at their limits, and with slopes from there a fit seems to end far from its minimum. Those of an
        explanation of it that lacks little may be held throughout.
        """
        settings, to_noise = self.settings.fit, self.premises.floor_is_noise
        slopes = self.tolerance_slopes if quick else None
        loose = quick or (to_noise and self.tolerance_slopes is not None)  # tolerances decide how well sizes are known
        enough = settings.enough if loose else settings.exactly
        share = settings.enough_of_rest * (1.0 if quick else 0.1)
        return fit_candidate(
            predictor,
            self.data,
            start,
            iterations,
            tolerance_slopes=held if to_noise else slopes,
            first_slopes=slopes if to_noise else None,
            enough=max(enough, self.data.negligible),
            rival=rival,
            share=share if to_noise else 0.0,
            roughly=quick and to_noise,
            settings=settings,
            stop=self.deadline.of_fit(finishing=finishing),
        )

    def _visible(self, fits: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Leave out fits of rich effects that are no more than a simpler one, which is fitted as well."""
        return [fit for fit in fits if not self._invisible(fit)]

    def _invisible(self, fit: CandidateFit) -> list[str]:
        """List the rich effects of a fit that are no more than a simpler one."""
        pairs = zip(fit.hypothesis, placed_effects(fit), strict=True)
        return [one.name for one, placed in pairs if not self.shows(placed)]

    def shows(self, placed: PlacedEffect) -> bool:
        """Return whether the encoder of a motor, or the best one, shows what a rich effect adds to a simpler one."""
        robot = self.null.model.robot
        noise = dict(zip(robot.joint_names, robot.encoder_noise, strict=True))
        return placed.effect.visible(noise.get(placed.location, float(robot.encoder_noise.min())))

    def _finished(self, fits: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Carry the best fits to their end, those after the first one as long as they may still come near it.

        Of several fits of the same effects, from different initial values, the best one is carried on.
        """
        finished = self.settings.search.finished
        ranked = best_of_each(fits)
        best = [self._continued(fit, np.inf) for fit in ranked[:1]]
        rival = min((fit.chi2 for fit in best), default=np.inf)
        best += self.parallel(
            "best effects", lambda fit: self._continued_rival(fit, rival), ranked[1:finished], needed=finished
        )
        return sorted([*best, *ranked[finished:]], key=lambda fit: fit.chi2)

    def _continued(self, fit: CandidateFit, rival: float, *, finishing: bool = False) -> CandidateFit:
        """Carry a fit to its end, from the best order of a rotor near its own."""
        fit = self._near_best_order(fit)
        return self._fit(fit.predictor, fit.theta, self._most_iterations, rival=rival, finishing=finishing)

    @property
    def _most_iterations(self) -> int:
        """Iterations of fits that are carried to their end; many tolerated numbers allow for fewer further ones."""
        settings, tolerated = self.settings.fit, self.null.fit.predictor.tolerance.n_free
        if not tolerated or not self.premises.floor_is_noise:
            return settings.final_iterations
        passes = tolerated // LANES + 3  # of derivatives with some effects, and of steps
        return max(settings.final_iterations, settings.valley_passes // passes)

    def _near_best_order(self, fit: CandidateFit) -> CandidateFit:
        """Fit again from the best orders of a rotor near that of a fit."""
        near = neighbouring_orders(fit, self.data, self.rows)
        rival = fit.chi2 if self.premises.floor_is_noise else np.inf
        return best_of([fit, *(self._quick(fit.predictor, start, rival) for start in near[:, :2].T)])

    def _continued_rival(self, fit: CandidateFit, rival: float) -> CandidateFit:
        """Carry a fit to its end, unless the time is over."""
        return fit if self.deadline.stops() else self._continued(fit, rival)

    def _joint(
        self,
        predictor: Predictor,
        theta: FloatArray,
        *,
        rival: float = np.inf,
        finishing: bool = False,
        slopes: FloatArray | None = None,
    ) -> CandidateFit:
        """Fit several effects for a few iterations, and on while what is left still falls.

        In a simulated log that is below the noise already, it goes on while that gains more than a parameter costs.

        Args:
            predictor: Predictor of the effects.
            theta: Initial value in the units of the fit, shape (n_fitted,).
            rival: Sum of squares of a better fit: this one ends where it has no hope to come near it.
            finishing: Whether it is part of the end of a search.
            slopes: Derivatives of the weighted prediction errors to the tolerated deviations near this fit, to be held,
                shape (n_values, n_tolerated); None where they are not known.
        """
        settings, n = self.settings.fit, self.data.n_values
        few = partial(
            self._fit, iterations=settings.joint_iterations, quick=True, rival=rival, finishing=finishing, held=slopes
        )
        fit = few(predictor, theta)
        for further in reversed(range(settings.final_iterations // settings.joint_iterations)):
            stopped = self.deadline.stops_finishing() if finishing else self.deadline.stops()
            without_hope = fit.iterations < settings.joint_iterations  # else it would have ended at its minimum
            if fit.converged or stopped or without_hope:
                break
            chi2, before = fit.chi2, max(fit.chi2 - n, 0.0)
            fit = few(predictor, fit.theta)
            if self.premises.floor_is_noise and not before and chi2 - fit.chi2 < np.log(n):
                break
            if fit.chi2 - n > settings.still_falling * before or _hopeless(fit.chi2 - n, before, further, rival - n):
                break
        return fit

    def _final(self, predictor: Predictor, theta: FloatArray, rival: float = np.inf) -> CandidateFit:
        """Fit to the end; of a simulated log a fit without hope to come near a rival ends early."""
        rival = rival if self.premises.floor_is_noise else np.inf
        return self._fit(predictor, theta, self._most_iterations, rival=rival, finishing=True)

    def completed(self, fit: CandidateFit) -> CandidateFit:
        """Carry a fit to its end, with a plant of its own laws alone and the finer steps that it may have.

        Tolerated deviations that made up for missing effects may stay far out of tolerance once these are found. Such
        a fit to a simulated log is also tried from the nominal numbers.
        """
        predictor, steps = self.null.predictor(fit.hypothesis), fit.predictor.plant.steps
        if is_finer(steps, predictor.plant.steps):
            predictor = self.null.predictor(fit.hypothesis, self.null.plant(fit.hypothesis, steps=steps))
        fit = self._continued(replace(fit, predictor=predictor), np.inf, finishing=True)
        beyond = compare(self.data, self.null.fit, settings=self.settings.ranking).beyond_tolerance(fit)
        if not self.premises.library_is_complete or not beyond or self.deadline.stops():
            return fit
        nominal = fit.theta.copy()
        nominal[fit.predictor.n_effect :] = 0.0
        return best_of([fit, self._fit(fit.predictor, nominal, self._most_iterations, rival=fit.chi2, finishing=True)])

    def at_its_end(self, fit: CandidateFit) -> CandidateFit:
        """Return a fit to a measured log where it ends, if it was ended well before, as fits that are compared are.

        What is left of the way moves sizes that the log hardly tells along valleys, away from those that torques show.
        """
        if self.premises.floor_is_noise or self.deadline.stops():
            return fit
        ended = self.completed(fit)
        return ended if ended.chi2 < (1 - WELL_BEFORE) * fit.chi2 else fit

    def to_compare(self, fit: CandidateFit) -> CandidateFit:
        """Carry a fit so far that it may be compared with others: of a simulated log near its end."""
        if not self.premises.floor_is_noise:
            return self.completed(fit)
        return self._fit(fit.predictor, fit.theta, self._most_iterations, quick=True)

    def finished(self, fits: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Carry the best fits to their end, and leave out those that are no more than a simpler one."""
        return self._visible(self._finished(fits))

    def visible(self, fits: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Sort fits, without those that are no more than a simpler one."""
        return sorted(self._visible(fits), key=lambda fit: fit.chi2)

    def parallel(
        self, step: str, work: Callable[[Item], Result], items: Sequence[Item], *, needed: int = 0
    ) -> list[Result]:
        """Work on items in parallel and return the results in their order.

        Args:
            step: Name that is shown as progress.
            work: What is done with an item.
            items: The items, the most important ones first.
            needed: Items that are worked on although the time is over; the others are left out then.
        """
        self.deadline.begin(step)
        results: list[Result] = []

        def begun(numbered: tuple[int, Item]) -> list[Result]:
            number, item = numbered
            return [] if number >= needed and self.deadline.stops() else [work(item)]

        with ThreadPoolExecutor(self.threads) as pool:
            try:
                for done, result in enumerate(pool.map(begun, enumerate(items)), 1):
                    results += result
                    if self.progress is not None:
                        self.progress(step, done / len(items))
            except BaseException:
                self.deadline.abandon()
                raise
        return results


def _hopeless(excess: float, before: float, further: int, rival: float) -> bool:
    """Return whether a fit does not come near a better one although it falls twice as fast as in its last iterations.

    Args:
        excess: What it leaves above the noise [1].
        before: What it left before the last iterations [1].
        further: How many times as many iterations are left.
        rival: What the better one leaves above the noise [1].
    """
    return before > 0 and excess * (excess / before) ** (2 * further) > max(rival, 0.0)
