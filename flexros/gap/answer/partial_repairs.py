"""The held-out log predicted with a part of the effects of an explanation."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.linearisation import linearise
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.held_out.errors_ahead import errors_ahead_of
from flexros.gap.held_out.gap_floor import over_expected_floor
from flexros.gap.prediction.compiled_plant import LANES

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.answer.decision import Findings
    from flexros.gap.held_out.errors_ahead import AheadErrors
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData


@dataclass(frozen=True, eq=False)
class _Base:
    """A model without effects.

    Attributes:
        predictor: Predictor of it with all effects, which may be switched off.
        deviations: Its tolerated deviations, fitted without them, shape (n_free,).
    """

    predictor: Predictor
    deviations: FloatArray


@dataclass(frozen=True, eq=False)
class PartialRepairs:
    """Prediction errors in the held-out log with some effects of the chosen explanation, and the others switched off.

    Numbers that the model lacks, such as rotor inertias, count as effects on the model as it was given. Effects keep
    the sizes at which they explain the fitted log together. Parameters of the robot that are known with a tolerance
    only are fitted again to that log: in the nominal model they imitate the effects as far as they may.

    Attributes:
        findings: The fits of one log, checked on another.
        before: Errors of the nominal model.
        after: Errors of the repaired one.
        known: Errors that were computed already, by the names of the effects.
    """

    findings: Findings
    before: AheadErrors
    after: AheadErrors
    known: dict[frozenset[str], AheadErrors] = field(default_factory=dict)

    @property
    def names(self) -> frozenset[str]:
        """All that the repaired model has: effects, and numbers that the given one lacks, effect@location."""
        findings = self.findings
        return findings.explanations.chosen.names - findings.beyond_search | findings.as_given.lacking

    @property
    def kept(self) -> frozenset[str]:
        """Those of the numbers with which the gap begins."""
        return self.findings.as_given.kept

    @cached_property
    def _data(self) -> FitData:
        """The log, of which predicted positions alone count: their errors ahead are the gap."""
        return self.findings.data.without_torques

    def prepare(self, parts: Iterable[Collection[str]]) -> None:
        """Compute the errors with several parts of the effects, names effect@location, at the same time."""
        new = [part for part in dict.fromkeys(map(frozenset, parts)) if part not in self.known]
        findings, chosen = self.findings, self.findings.explanations.chosen
        if not new:
            return
        if len(chosen.deviations):
            assert self._changes.size  # computed before the threads ask for it
        lacking, groups = findings.as_given.lacking, []
        for numbers in dict.fromkeys(part & lacking for part in new):
            alike, base = [part for part in new if part & lacking == numbers], self._base(numbers)
            groups += [(base, alike[begin : begin + LANES]) for begin in range(0, len(alike), LANES)]

        def predicted(group: tuple[_Base, Sequence[frozenset[str]]]) -> list[AheadErrors]:
            return errors_ahead_of(group[0].predictor, self._fitted(*group), findings.held)

        with ThreadPoolExecutor(findings.data.settings.cores) as pool:
            for (_, alike), every in zip(groups, pool.map(predicted, groups), strict=True):
                for part, errors in zip(alike, every, strict=True):
                    self.known[part] = over_expected_floor(errors, findings.model, findings.held)

    def errors(self, part: Collection[str]) -> AheadErrors:
        """Return the errors with a part of the effects, names effect@location."""
        self.prepare([part])
        return self.known[frozenset(part)]

    def closed_by(self, part: Collection[str]) -> float:
        """Return the share of the gap that a part of the effects closes [1]."""
        return (self.before.mean - self.errors(part).mean) / (self.before.mean - 1.0)

    def by_joint(self, errors: AheadErrors) -> FloatArray:
        """Return the gap at each joint over the whole gap before [1], shape (M,)."""
        shares = (errors.squares.mean(axis=0) - 1.0) / errors.squares.shape[1] / (self.before.mean - 1.0)
        n = self.findings.model.robot.n_motors
        return np.array([shares[errors.of_joint(motor, n)].sum() for motor in range(n)])

    def _base(self, numbers: frozenset[str]) -> _Base:
        """Prepare the given model with some of the numbers that it lacks."""
        chosen, given = self.findings.explanations.chosen, self.findings.as_given
        predictor = chosen.predictor if numbers == given.lacking else given.predictor(chosen.hypothesis, numbers)
        return _Base(predictor, given.deviations(numbers))

    def _fitted(self, base: _Base, parts: Sequence[frozenset[str]]) -> FloatArray:
        """Return the parameters with some parts of the effects, tolerated deviations fitted, shape (n_fitted, sets).

        Each effect adds its change to the deviations of the nominal model, all together those of the explanation; then
        they are improved by a step with the slopes of the nominal model.
        """
        chosen, data, predictor = self.findings.explanations.chosen, self._data, base.predictor
        n = chosen.predictor.n_effect
        sets = np.stack([chosen.switched_off(chosen.names - part) for part in parts], axis=-1)
        if n == len(sets):
            return sets
        low, high = (bound[n:, None] for bound in predictor.bounds)
        names = sorted(chosen.names)
        within = np.array([[name in part for part in parts] for name in names], dtype=float)
        sets[n:] = np.clip(base.deviations[:, None] + self._changes @ within, low, high)
        residuals = data.residuals(predictor, sets)[:, : len(parts)]
        improved = sets.copy()
        improved[n:] = np.clip(sets[n:] - self._step(residuals, sets[n:]), low, high)
        better = chi2_of(predictor, data, improved) < np.sum(residuals**2, axis=0) + self._prior(sets[n:])
        return np.where(better, improved, sets)

    def _step(self, residuals: FloatArray, deviations: FloatArray) -> FloatArray:
        """Return by how much less some deviations fit best by linear theory, shape (n_tolerated, sets)."""
        misfit = self._data.misfit
        information = self._slopes.T @ self._slopes + misfit * np.eye(len(deviations))
        gradient = self._slopes.T @ residuals + misfit * deviations
        step: FloatArray = np.asarray(np.linalg.solve(information, np.nan_to_num(gradient)), dtype=float)
        return step

    def _prior(self, deviations: FloatArray) -> FloatArray:
        penalty: FloatArray = self._data.misfit * np.sum(deviations**2, axis=0)
        return penalty

    @cached_property
    def _changes(self) -> FloatArray:
        """Changes of the deviations of the nominal model by each effect, by their names, shape (n_tolerated, k).

        By linear theory; what is missing to the deviations of the explanation is added in proportion.
        """
        chosen, data, null = self.findings.explanations.chosen, self._data, self.findings.as_given.nominal
        names, changes = sorted(chosen.names), []
        nominal = null.residual(data)
        for begin in range(0, len(names), LANES):
            group = names[begin : begin + LANES]
            sets = np.stack([chosen.switched_off(chosen.names - {name}) for name in group], axis=-1)
            sets[chosen.predictor.n_effect :] = null.deviations[:, None]
            moved = data.residuals(chosen.predictor, sets)[:, : len(group)] - nominal[:, None]
            changes.append(-self._step(moved, np.zeros((len(null.deviations), len(group)))))
        linear = np.concatenate(changes, axis=1)
        missing = (chosen.deviations - null.deviations)[:, None] - linear.sum(axis=1, keepdims=True)
        sizes = np.abs(linear)
        return np.asarray(linear + missing * sizes / np.maximum(sizes.sum(axis=1, keepdims=True), 1e-300))

    @cached_property
    def _slopes(self) -> FloatArray:
        """Derivatives of the weighted prediction errors to the tolerated deviations, shape (n_values, n_tolerated)."""
        null = self.findings.as_given.nominal
        return linearise(null.predictor, self._data, null.theta).slopes
