"""Fits of candidates to one log: each alone, then in addition to the best explanations."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import effects
from flexros.effects.base_tilt import BaseTilt
from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.tool_error import AbstractToolError
from flexros.gap.candidates.candidate import alike, list_candidates, names_of
from flexros.gap.fit.candidate_fit import CandidateFit, best_of_each
from flexros.gap.fit.directions import directions_of, switched_off
from flexros.gap.fit.initial_values import starts_of
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.fit.torques.unknown_numbers import UNCERTAIN
from flexros.gap.prediction.compiled_plant import LANES, grouped
from flexros.gap.search.fits.additions import addition_of, best_starts
from flexros.gap.search.fits.simpler_fits import SimplerFits
from flexros.gap.search.periodic.harmonic_candidates import harmonic_candidates, harmonics_in_place
from flexros.record.one_way import moves_one_way

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.candidates.competitors import Competitors
    from flexros.gap.candidates.scales import Scales
    from flexros.gap.fit.directions import Directions
    from flexros.gap.fit.screening import Surroundings
    from flexros.gap.prediction.compiled_plant import CompiledPlant
    from flexros.gap.search.fits.additions import Addition
    from flexros.prediction.integration_step import IntegrationSteps


SELDOM, ONE_SIZE = 0.1, 0.8
"""Share of the samples in which the torque behind a relay may be smaller, and its least size in the others, over the
largest [1] (chosen)."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Search(SimplerFits):
    """The common ground of all fits of candidates to one log.

    Attributes:
        base: The fit around which candidates are screened: that of the nominal model, of what the torques show, or the
            explanation of an earlier search.
        base_residual: Its weighted prediction errors, shape (n_values,).
        scales: Largest torques, speeds and deflections of the log.
        distance: Sum of the squares by which the weighted prediction errors of two fits differ.
        chance: What their sums of squares may differ by without evidence, by parts of a measured log [1].
        competitors: Effects and locations that compete.
        left_before: Mean squared prediction error of the base in the same log tied more closely, where an earlier
            search ended with it [1]; None where there was none.
        in_vain: What explanations left that an exchange made worse [1], by the effect and the candidate in its place.
    """

    base: CandidateFit
    base_residual: FloatArray
    scales: Scales
    distance: Callable[[CandidateFit, CandidateFit], float]
    chance: Callable[[CandidateFit, CandidateFit], float]
    competitors: Competitors
    left_before: float | None = None
    in_vain: dict[tuple[str, str], float] = field(init=False, default_factory=dict)
    _levels: dict[tuple[frozenset[str], bytes], float] = field(init=False, default_factory=dict)

    @property
    def resumed(self) -> bool:
        """Whether the base is the explanation of an earlier search, in the same log tied more closely."""
        return self.left_before is not None

    @property
    def from_torques(self) -> bool:
        """Whether the search begins with effects that the torques show, rather than with the nominal model."""
        return self.base is not self.null.fit and not self.resumed

    @property
    def of_torques(self) -> frozenset[str]:
        """Names of these effects, effect@location; none where the search begins with others."""
        return self.base.names if self.from_torques else frozenset()

    @property
    def torques_decide(self) -> bool:
        """Whether it does so on a real machine, where torques tell more than predictions of simulated accuracy."""
        return self.from_torques and self.premises.torques_tell

    def shown_by_torques(self, fit: CandidateFit) -> frozenset[str]:
        """Return the names of the effects of a fit that torques show, or that replaced one of them at its motor.

        The regression takes a wrong torque constant for an inertia, and a turned weight for a constant torque:
        exchanged for each other, they are as real.
        """
        replaced = [one for one in self.base.hypothesis if one.name in self.of_torques - fit.names]
        others = (one for one in fit.hypothesis if any(alike(one, other) for other in replaced))
        return (self.of_torques & fit.names) | names_of(tuple(others))

    def candidates(self, *, for_curve: bool = False) -> tuple[Candidate, ...]:
        """List the candidates that come from the ranges of effects; those of harmonics follow from a fit.

        A measured torque is what a limit left of it, so that no limit competes, nor does one of a torque that only
        changes its sign: that would scale all of it. Where a motor moves in one direction only, friction has no
        difference between directions.

        A slant of the base is none of them where torques count, see `slants`.

        Args:
            for_curve: Whether those are listed that are tried in place of a curve.
        """
        every, torques = self._every(for_curve=for_curve), self.data.torques is not None
        return tuple(one for one in every if not (torques and one.effect is BaseTilt))

    def slants(self) -> tuple[Candidate, ...]:
        """List the slant of the base where torques count: they must show it, as two angles imitate more than one."""
        if self.data.torques is None:
            return ()
        return tuple(one for one in self._every() if one.effect is BaseTilt)

    def _every(self, *, for_curve: bool = False) -> tuple[Candidate, ...]:
        """List the candidates that compete, a slant of the base included."""
        tool = self.data.tool is not None
        model, measured = self.null.model, self.data.record.imported
        return tuple(
            self._told(candidate)
            for candidate in list_candidates(
                model.robot, self.scales, measured=measured, known=model.laws, for_curve=for_curve
            )
            if self.competitors.contain(candidate)
            and self._known(candidate)
            and not (candidate.cuts_off and (self.data.record.measured_torque or self._switches(candidate.location)))
            and not self._acts_on_nothing(candidate)
            and (tool or not issubclass(candidate.effect, AbstractToolError))
        )

    def _told(self, candidate: Candidate) -> Candidate:
        """Return a candidate without the sizes that a motion in one direction does not tell from the others."""
        names = self.null.model.robot.joint_names
        if not candidate.effect.uneven or candidate.location not in names:
            return candidate
        if not moves_one_way(self.data.record, names.index(candidate.location)):
            return candidate
        free = tuple(one for one in candidate.free if one.name not in candidate.effect.uneven)
        return replace(candidate, free=free)

    def _switches(self, motor: str) -> bool:
        """Return whether the torque of a motor has one size and changes its sign alone, as behind a relay."""
        record = self.data.record
        size = np.abs(record.torque[record.valid, self.null.model.robot.joint_names.index(motor)])
        return bool(np.quantile(size, SELDOM) > ONE_SIZE * size.max())

    def harmonics(self, fit: CandidateFit) -> tuple[Candidate, ...]:
        """List the candidates with the orders of the rotors at which the residuals of a fit repeat."""
        if not any(self.competitors.include(effect) for effect in effects().values() if effect.harmonics):
            return ()
        if self.deadline.stops():
            return ()
        robot, settings = self.null.model.robot, self.settings.search
        found = harmonic_candidates(robot, self.data, fit.residual(self.data), fit.states(self.data), settings)
        return tuple(candidate for candidate in found if self.competitors.contain(candidate))

    def harmonics_in_place(self, fit: CandidateFit, replaced: Candidate) -> tuple[Candidate, ...]:
        """List the candidates that may have the order of an effect of a fit in its place, in a simulated log."""
        if not self.premises.library_is_complete or self.deadline.stops():
            return ()
        found = harmonics_in_place(fit, replaced, self.data, self.settings.search)
        return tuple(candidate for candidate in found if self.competitors.contain(candidate))

    def _acts_on_nothing(self, candidate: Candidate) -> bool:
        """Whether a candidate changes the torque of motors that have none throughout the log, as where they swing."""
        if not (issubclass(candidate.effect, AbstractCommandLaw) or candidate.effect.delays_commands):
            return False
        record, names = self.data.record, self.null.model.robot.joint_names
        changed = [names.index(candidate.location)] if candidate.location in names else slice(None)
        return record.command is None and not record.torque[:, changed].any()

    def _known(self, candidate: Candidate) -> bool:
        """Whether the numbers that a candidate changes are known well enough for an error of them to be a cause."""
        if not issubclass(candidate.effect, AbstractChangedValues):
            return True
        effect = candidate.typical().effect
        assert isinstance(effect, AbstractChangedValues)
        tolerance = self.null.fit.predictor.tolerance
        deviations = dict(zip(tolerance.names, tolerance.deviations, strict=True))
        changed = effect.values(self.null.model.robot, candidate.location)
        return not changed or min(deviations.get(name, 0.0) for name in changed) < UNCERTAIN

    def directions(self, candidates: Sequence[Candidate], fit: CandidateFit | None = None) -> list[Directions]:
        """Predict the log with every initial value of the candidates that a fit lacks.

        What counts is the change of a prediction, so that long integration steps serve: of a simulated log, the fit is
        predicted with the same steps.

        Args:
            candidates: The candidates.
            fit: The fit; default: the base.
        """
        self.deadline.begin("candidates")
        if self.deadline.stops():
            return []  # plants are compiled for all of them
        around = self.base if fit is None else fit
        residual = self.base_residual if fit is None else fit.residual(self.data)
        new = [candidate for candidate in candidates if candidate.name not in around.names]
        rough = self.premises.floor_is_noise
        plants = self.plants(around, new, rough=rough)
        own = around.predictor.plant.steps
        residuals = {own: residual}
        for steps in {plant.steps for plant in plants.values()} - {own} if rough else ():
            again = self.null.predictor(around.hypothesis, self.null.plant(around.hypothesis, steps=steps))
            residuals[steps] = self.data.residuals(again, around.theta[:, None])[:, 0]
        work = partial(self._directions, around, residuals)
        return self.parallel("candidates", work, [(one, plants[one]) for one in new])

    def plants(
        self, fit: CandidateFit, candidates: Sequence[Candidate], *, rough: bool = False
    ) -> dict[Candidate, CompiledPlant]:
        """Compile plants of a fit with each of some candidates, several candidates at a time.

        Args:
            fit: The fit.
            candidates: The candidates.
            rough: Whether their predictions are compared with each other alone, see `CompiledPlant`.
        """
        groups = grouped(tuple(dict.fromkeys(candidates)), self.settings.search.compiled)
        with ThreadPoolExecutor(self.threads) as pool:
            plants = list(pool.map(lambda group: self.null.plant((*fit.hypothesis, *group), rough=rough), groups))
        return {one: plant for group, plant in zip(groups, plants, strict=True) for one in group}

    def _directions(
        self, fit: CandidateFit, residuals: Mapping[IntegrationSteps, FloatArray], pair: tuple[Candidate, CompiledPlant]
    ) -> Directions:
        candidate, plant = pair
        alone = fit is self.null.fit
        most = self.settings.fit.most_starts if alone or candidate.resonates else LANES
        own = starts_of((candidate,), most, of_one_size=not alone)
        predictor = self.null.predictor((*fit.hypothesis, candidate), plant)
        residual = residuals.get(predictor.plant.steps, residuals[fit.predictor.plant.steps])
        return directions_of(predictor, self.data, fit.theta, own, residual, self.rows, self.deadline.stops)

    def singles(self, directions: Sequence[Directions]) -> list[CandidateFit]:
        """Fit the candidates that promise most, each alone: all for a few iterations, the best ones to the end.

        An effect that extends simpler ones starts from the fit of the one that gains most, and only where that gains
        anything. Fits to a simulated log end early where they have no hope to come near the one that promises most.

        Args:
            directions: The candidates.

        Returns:
            Fits, the best first.
        """
        if not directions:
            return []
        null = self.null.fit
        surroundings = self.surroundings(null)
        simple = [direction for direction in directions if not direction.candidate.effect.extends]
        promises = [surroundings.gains(direction.changes)[0].max() for direction in simple]
        promising = [simple[index] for index in np.argsort(-np.array(promises), kind="stable")]
        single = partial(self._single, surroundings=surroundings)
        fits = [single(one) for one in promising[:1]]
        further = promising[1 : self.settings.search.fitted]
        fits += self.parallel("single effects", partial(single, rival=_least(fits)), further)
        worth = float(np.log(self.data.n_values))
        gaining = [fit for fit in best_of_each(fits) if self.null.fit.chi2 - fit.chi2 > worth]
        simpler = [
            (one.candidate, next((fit for fit in gaining if _extends(one.candidate, fit)), None)) for one in directions
        ]
        pairs = [(candidate, fit) for candidate, fit in simpler if fit is not None]
        extended = partial(self._extended, rival=_least(fits))
        fits += self.parallel("richer effects", lambda pair: extended(*pair), pairs)
        return self.finished(fits)

    def _single(self, direction: Directions, surroundings: Surroundings, rival: float = np.inf) -> CandidateFit:
        """Fit a candidate from its two best initial values."""
        best = best_starts(direction, surroundings)
        deviations = np.repeat(self.null.fit.deviations[:, None], len(best), axis=1)
        starts = np.vstack([direction.starts[:, best], deviations])
        return self._from_grid(self.null.predictor((direction.candidate,)), starts, rival)

    def _extended(self, candidate: Candidate, simple: CandidateFit, rival: float) -> CandidateFit:
        """Fit a candidate from the parameters of a simpler effect that it contains."""
        values = simple.predictor.values(simple.theta)[0]
        shared = candidate.effect.extends[simple.hypothesis[0].effect.name]
        predictor = self.null.predictor((candidate,))
        own = starts_of((candidate,), self.settings.fit.most_starts)
        for index, free in enumerate(candidate.free):
            if free.name in shared:
                own[index] = free.encode(values[shared[free.name]])
        own = np.unique(own, axis=1)
        deviations = np.repeat(simple.deviations[:, None], own.shape[1], axis=1)
        return self._from_grid(predictor, np.vstack([own, deviations]), rival)

    def misfit(self, directions: Sequence[Directions]) -> float:
        """Estimate the mean squared error that is left when all candidates are fitted together, by linear theory [1].

        Args:
            directions: The candidates; of each one the best initial value counts.
        """
        null, settings = self.null.fit, self.settings.search
        surroundings = self.surroundings(null)
        additions = self.additions(directions, null, surroundings)
        changes = np.array([addition.change for addition in additions]).reshape(-1, len(self.rows)).T
        together = surroundings.independent(changes, settings.most_effects, settings.kept_of_misfit)
        return max(surroundings.left(changes[:, together]) / self.data.n_values, 1.0)

    def additions(
        self, directions: Sequence[Directions], fit: CandidateFit, surroundings: Surroundings
    ) -> list[Addition]:
        """List the candidates that a fit lacks, by their predicted gain in addition to it.

        Args:
            directions: The candidates.
            fit: The fit.
            surroundings: The same, linearised.
        """
        additions = [
            addition_of(direction, fit, surroundings)
            for direction in directions
            if direction.candidate.name not in fit.names and direction.usable.any()
        ]
        return sorted(additions, key=lambda addition: -addition.gain)

    def removals(self, fit: CandidateFit, surroundings: Surroundings) -> list[Surroundings]:
        """Linearise a fit without each of its effects; results are shared like those of `surroundings`."""
        known = self._around(fit)
        if known is not None and known.removals:
            return known.removals
        removals = self.removals_together(fit, surroundings, [(one.name,) for one in fit.hypothesis])
        if known is not None:
            known.removals[:] = removals
        return removals

    def removals_together(
        self, fit: CandidateFit, surroundings: Surroundings, sets: Sequence[Collection[str]]
    ) -> list[Surroundings]:
        """Linearise a fit without several of its effects at once, for each of some sets of their names."""
        changes = switched_off(fit, self.data, fit.residual(self.data), self.rows)
        removals = []
        for names in sets:
            members = [candidate.name in names for candidate in fit.hypothesis]
            removals.append(surroundings.without(fit.columns(names), changes[:, members].sum(axis=1)))
        return removals

    def level_without(self, fit: CandidateFit, names: Collection[str]) -> float:
        """Return the mean squared prediction error of a fit with some of its effects switched off [1].

        Args:
            fit: The fit.
            names: Names of these effects.
        """
        theta = fit.switched_off(names)
        key = (fit.names, theta.tobytes())
        if key not in self._levels:
            self._levels[key] = float(chi2_of(fit.predictor, self.data, theta[:, None])[0]) / self.data.n_values
        return self._levels[key]

    def with_visible(self, fit: CandidateFit) -> CandidateFit:
        """Fit again with simpler effects in place of those that are no more than these and spoil the fit of others."""
        names = self._invisible(fit)
        if not names:
            return fit
        known = {candidate.name: candidate for candidate in self.candidates()}
        rest = tuple(candidate for candidate in fit.hypothesis if candidate.name not in names)
        simple: list[Candidate] = []
        sizes: list[float] = []
        for rich, values in zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True):
            for effect, shared in rich.effect.extends.items() if rich.name in names else ():
                own = {shared[name]: value for name, value in values.items() if name in shared}
                other = known.get(f"{effect}@{rich.location}")
                if other is not None and other.name not in fit.names and own:
                    simple.append(other)
                    sizes += [one.encode(own.get(one.name, 0.0 if one.signed else one.starts[0])) for one in other.free]
        if not (rest or simple):
            return fit
        n_effect = fit.predictor.n_effect
        kept = fit.theta[:n_effect][~fit.columns(names)[:n_effect]]
        predictor = self.null.predictor((*rest, *simple), fit.predictor.plant)
        return self._joint(predictor, np.concatenate([kept, sizes, fit.deviations]), finishing=True)


def _least(fits: Sequence[CandidateFit]) -> float:
    """Return the least sum of squares of some fits [1]; infinite without one."""
    return min((fit.chi2 for fit in fits), default=np.inf)


def _extends(candidate: Candidate, simple: CandidateFit) -> bool:
    """Return whether a candidate contains the effect of a fit, at the same location."""
    other = simple.hypothesis[0]
    return other.effect.name in candidate.effect.extends and other.location == candidate.location
