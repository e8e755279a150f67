"""Names of an answer with all tolerances of the nominal model halved and doubled, as nobody has measured them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import lsq_linear

from flexros.gap.answer.decision import effect_location
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.least_squares import fit as fit_again
from flexros.gap.fit.null_fit import predictor_for
from flexros.gap.schema import ToleranceSensitivity

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.torques.unknown_numbers import UnknownNumbers
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.forward_selection import Explanations
    from flexros.gap.settings import SensitivitySettings

HALVED, STATED, DOUBLED = 0.5, 1.0, 2.0
"""Tolerances over the stated ones."""
REGULAR = 1e-12
"""Unit added to an information matrix, over its largest element, as not all parameters are determined [1]."""


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What an answer owes to the stated tolerances.

    Attributes:
        explanations: The explanations; where a name changes, with the mean of their probabilities at all tolerances.
        rows: The effects that are named at some tolerance.
        elsewhere: Explanations that are the most probable ones at other tolerances, but not at the stated ones.
    """

    explanations: Explanations
    rows: tuple[ToleranceSensitivity, ...] = ()
    elsewhere: tuple[CandidateFit, ...] = ()


def sensitivity_of(
    explanations: Explanations,
    data: FitData,
    model: RobotWithEffects,
    unknown: UnknownNumbers,
    settings: SensitivitySettings | None,
    stop: Callable[[], bool],
) -> Sensitivity:
    """Compare the explanations of a log again with all tolerances halved and doubled.

    The prior of the tolerated deviations d, in standard deviations, becomes the factor s weaker. By linear theory
    around each fit, with its information H and the misfit m of the data, its sum of squares becomes

        chi2 + m (1/s^2 - 1) d'd - g' (H + m (1/s^2 - 1) I_d)^-1 g,    g = m (1/s^2 - 1) d,

    or more where deviations are at the limit of their search. Where another explanation leads then, it and the one
    that leads at the stated tolerances are fitted again, so that the name changes only where it really does. Simulated
    logs and exact models have no such guesses.

    Args:
        explanations: All fits, and the chosen one.
        data: The fitted log.
        model: The nominal model.
        unknown: Numbers that the model lacks, whose uncertainty is no stated tolerance.
        settings: Settings; None leaves this out.
        stop: Asked before each fit; True ends them.
    """
    tolerance = explanations.null.predictor.tolerance
    estimated = unknown.names(model.robot)
    guessed = np.array([name not in estimated for name in tolerance.names], dtype=bool)
    if settings is None or data.record.simulated or not explanations.detected or not guessed.any():
        return Sensitivity(explanations)
    probabilities = {STATED: explanations.probabilities}
    leading = {}
    for factor in (HALVED, DOUBLED):
        scaled = _Scaled(explanations, data, model, np.where(guessed, factor, 1.0))
        probabilities[factor], leading[factor] = scaled.compared(settings.refitted, stop)
    first = explanations.rivals[int(np.argmax(explanations.probabilities))]
    elsewhere = tuple(dict.fromkeys(fit for fit in leading.values() if fit.names != first.names))
    rows = _rows(explanations, probabilities, settings.named)
    if not elsewhere:
        return Sensitivity(explanations, rows)
    mean = np.mean(list(probabilities.values()), axis=0)
    order = np.argsort(-mean, kind="stable")
    averaged = replace(
        explanations, rivals=tuple(explanations.rivals[index] for index in order), probabilities=mean[order]
    )
    return Sensitivity(averaged, rows, elsewhere)


def _rows(
    explanations: Explanations, probabilities: dict[float, FloatArray], named: float
) -> tuple[ToleranceSensitivity, ...]:
    """List the effects that are named at some tolerance, with their probabilities."""
    rows = []
    for name in sorted({name for fit in explanations.rivals for name in fit.names}):
        there = np.array([name in fit.names for fit in explanations.rivals])
        sums = {factor: float(min(one[there].sum(), 1.0)) for factor, one in probabilities.items()}
        if max(sums.values()) < named:
            continue
        located = effect_location(name)
        rows.append(
            ToleranceSensitivity(
                effect=located.effect,
                location=located.location,
                halved=sums[HALVED],
                stated=sums[STATED],
                doubled=sums[DOUBLED],
                changes=min(sums.values()) < named,
            )
        )
    return tuple(sorted(rows, key=lambda row: (-row.changes, -row.stated)))


@dataclass(frozen=True, eq=False)
class _Scaled:
    """The explanations at other tolerances: `factors` over the stated ones, shape (n_names,)."""

    explanations: Explanations
    data: FitData
    model: RobotWithEffects
    factors: FloatArray

    def compared(self, refitted: int, stop: Callable[[], bool]) -> tuple[FloatArray, CandidateFit]:
        """Return the probabilities of the rivals, and the most probable one, as it was fitted at first.

        Args:
            refitted: Most times that a new leader is fitted again.
            stop: True ends this.
        """
        explanations = self.explanations
        fits = {fit: replace(fit, chi2=self._reweighed(fit)) for fit in explanations.comparison.fits}
        fits[explanations.null] = replace(explanations.null, chi2=self._reweighed(explanations.null))
        stated = explanations.rivals[int(np.argmax(explanations.probabilities))]
        again: set[CandidateFit] = set()
        while True:
            probabilities = self._probabilities(fits)
            first = explanations.rivals[int(np.argmax(probabilities))]
            new = {first, stated} - again
            if first.names == stated.names or not new or not refitted or len(again) > refitted or stop():
                return probabilities, first
            for fit in new:
                fits[fit] = replace(fit, chi2=self._fitted(fit))
            again |= new

    def _probabilities(self, fits: dict[CandidateFit, CandidateFit]) -> FloatArray:
        """Compare the fits with other sums of squares; the distances of their predictions stay as they are."""
        comparison = self.explanations.comparison
        first = {changed: fit for fit, changed in fits.items()}
        distance = comparison.distance

        def between(fit: CandidateFit, other: CandidateFit) -> float:
            assert distance is not None
            return distance(first[fit], first[other])

        changed = replace(
            comparison,
            null=fits[comparison.null],
            fits=tuple(fits[fit] for fit in comparison.fits),
            distance=None if distance is None else between,
        )
        return changed.probabilities([fits[fit] for fit in self.explanations.rivals])

    def _reweighed(self, fit: CandidateFit) -> float:
        """Estimate the sum of squares at these tolerances by linear theory, within the bounds of the deviations [1]."""
        n, deviations = fit.predictor.n_effect, fit.deviations
        _, units = self._scaled(fit.predictor.tolerance)
        weights = units.T @ units  # of the prior, 1 at the stated tolerances
        change = self.data.misfit * (weights - np.eye(len(deviations)))
        chi2 = fit.chi2 + float(deviations @ change @ deviations)
        if not fit.information.size:
            return max(chi2, 0.0)
        low, high = fit.predictor.bounds
        low[n:], high[n:] = (bound[n:] / np.sqrt(np.diag(weights)) for bound in (low, high))
        information = fit.information.copy()
        information[n:, n:] += change
        information += REGULAR * np.diag(information).max() * np.eye(len(information))
        lower = np.linalg.cholesky(information)
        wanted = np.linalg.solve(lower, -np.concatenate([np.zeros(n), change @ deviations]))
        step = lsq_linear(lower.T, wanted, (low - fit.theta, high - fit.theta)).x
        return max(chi2 + float(np.sum((lower.T @ step - wanted) ** 2) - np.sum(wanted**2)), 0.0)

    def _fitted(self, fit: CandidateFit) -> float:
        """Fit again at these tolerances and return the sum of squares [1]."""
        predictor, settings = fit.predictor, self.data.settings.fit
        tolerance, units = self._scaled(predictor.tolerance)
        other = predictor_for(self.data, self.model, predictor.hypothesis, tolerance, predictor.plant)
        start = np.concatenate([fit.theta[: predictor.n_effect], units @ fit.deviations])
        enough = max(settings.exactly, self.data.negligible)
        return fit_again(other, self.data, start, settings.joint_iterations, enough=enough, settings=settings).chi2

    def _scaled(self, tolerance: Tolerance) -> tuple[Tolerance, FloatArray]:
        """Return the other tolerance, and the matrix that converts deviations to its units, shape (n_free, n_free)."""
        deviations = tuple((self.factors * np.array(tolerance.deviations)).tolist())
        if tolerance.directions is None:
            return Tolerance(tolerance.names, deviations), np.diag(1.0 / self.factors)
        directions, units = np.linalg.qr(tolerance.directions / self.factors[:, None])
        return Tolerance(tolerance.names, deviations, directions), units
