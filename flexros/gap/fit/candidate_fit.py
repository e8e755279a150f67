"""A fitted hypothesis: its parameters at the minimum and how far it explains a log."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.candidates.candidate import names_of

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.candidates.candidate import Hypothesis
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData


@dataclass(frozen=True, eq=False)
class CandidateFit:
    """A fitted hypothesis.

    Attributes:
        predictor: Predictor of the hypothesis.
        theta: Parameters at the minimum in the units of the fit: those of the effects, then the tolerated deviations in
            standard deviations, along the directions of the tolerance, shape (n_fitted,).
        chi2: Sum of the squared weighted prediction errors and of the squared tolerated deviations times the misfit of
            the data [1].
        information: J'J + prior where it was linearised last, shape (n_fitted, n_fitted); empty where not computed.
        iterations: Iterations taken.
        converged: Whether the sum of squares fell no more.
    """

    predictor: Predictor
    theta: FloatArray
    chi2: float
    information: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    iterations: int = 0
    converged: bool = False

    @property
    def hypothesis(self) -> Hypothesis:
        """The candidates that it contains."""
        return self.predictor.hypothesis

    @property
    def names(self) -> frozenset[str]:
        """Names of these candidates, effect@location."""
        return names_of(self.hypothesis)

    def columns(self, names: Collection[str]) -> BoolArray:
        """Return which fitted parameters belong to candidates of these names, shape (n_fitted,)."""
        owned = [candidate.name in names for candidate in self.hypothesis for _ in candidate.free]
        return np.array([*owned, *([False] * len(self.deviations))], dtype=bool)

    def switched_off(self, names: Collection[str]) -> FloatArray:
        """Return the parameters with the candidates of these names at neutral values, shape (n_fitted,)."""
        neutral = [candidate.neutral(free) for candidate in self.hypothesis for free in candidate.free]
        theta = self.theta.copy()
        for column in np.flatnonzero(self.columns(names)):
            value = neutral[column]
            theta[column] = theta[column] if value is None else value
        return theta

    @property
    def deviations(self) -> FloatArray:
        """Tolerated deviations along the directions of the tolerance, in standard deviations [1], shape (n_free,)."""
        return self.theta[self.predictor.n_effect :]

    @property
    def prior_penalty(self) -> float:
        """Sum of the squared tolerated deviations [1]; `chi2` contains it times the misfit of the data."""
        return float(np.sum(self.deviations**2))

    def residual(self, data: FitData) -> FloatArray:
        """Compute the weighted prediction errors in a log, which need not be the fitted one, shape (n_values,)."""
        residual: FloatArray = data.residuals(self.predictor, self.theta[:, None])[:, 0].copy()
        return residual

    def states(self, data: FitData) -> FloatArray:
        """Predict the states of a log, shape (n, n_states)."""
        prediction = data.predict(self.predictor, self.theta[:, None], record_states=True)
        assert prediction.states is not None
        states: FloatArray = prediction.states[:, :, 0].copy()
        return states


def best_of(fits: Sequence[CandidateFit]) -> CandidateFit:
    """Return the fit with the smallest sum of squares."""
    return min(fits, key=lambda fit: fit.chi2)


def best_of_each(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Keep the best fit of every set of effects, the best first."""
    best: dict[frozenset[str], CandidateFit] = {}
    for fit in fits:
        if fit.names not in best or fit.chi2 < best[fit.names].chi2:
            best[fit.names] = fit
    return sorted(best.values(), key=lambda fit: fit.chi2)


def first_parameters(fit: CandidateFit) -> dict[str, float]:
    """Return the first parameter of every effect of a fit, mostly its size, by effect@location [its unit].

    Args:
        fit: The fit.
    """
    values = fit.predictor.values(fit.theta)
    return {one.name: next(iter(found.values())) for one, found in zip(fit.hypothesis, values, strict=True)}
