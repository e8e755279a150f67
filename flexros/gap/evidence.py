"""Evidence: from sums of squares to probabilities that are neither sure beyond reason nor blind for small effects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.model_change import AbstractChangedValues

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.fit import Fit
    from flexros.gap.hypothesis import Suspect

PER_PARAMETER = 3.0
"""What a fitted number costs in the logarithm of the probability [nats] (tempered; development seeds)."""
TEMPER_PLAIN = 2e-4
"""Share of the gap by which effects that are one number of the model may be wrong in form [1] (development seeds)."""
TEMPER_SHAPED = 2e-3
"""The same for effects with a law of their own: friction, gap, spring law, ripple [1] (development seeds)."""
SIGNIFICANT = 4.0
"""Standard deviations of V without gap beyond which something is left [1] (development seeds)."""
DETECTED = 6.0
"""What a fitted effect must gain beyond its penalty to be detected [1] (development seeds)."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """Fits of one log, compared.

    Attributes:
        nothing: The nominal model, with what is tolerated fitted.
        fits: All other fits.
        n_values: Number of prediction errors that count.
        floor_error: Relative standard deviation of the variance of the noise [1].
    """

    nothing: Fit
    fits: tuple[Fit, ...]
    n_values: int
    floor_error: float = 0.0

    def level(self, one: Fit) -> float:
        """Return the mean squared weighted prediction error V of a fit; 1 without gap."""
        return one.chi2 / self.n_values

    def gain(self, one: Fit) -> float:
        """Return twice the gain in log-likelihood over the nominal model, with the noise estimated: N ln(V0 / V)."""
        return self.n_values * float(np.log(self.nothing.chi2 / one.chi2))

    def penalty(self, one: Fit) -> float:
        """Return what the fitted numbers cost by the Bayesian information criterion (Schwarz 1978): p ln N."""
        return one.predictor.n_effect * float(np.log(self.n_values))

    def score(self, one: Fit) -> float:
        """Return gain less penalty."""
        return self.gain(one) - self.penalty(one)

    @property
    def spread(self) -> float:
        """Standard deviation of V without gap: sqrt(2 / N), and how well the variance of the noise is known."""
        return float(np.hypot(np.sqrt(2.0 / self.n_values), self.floor_error))

    def significant(self, one: Fit) -> bool:
        """Tell whether a fit leaves more than noise."""
        return self.level(one) - 1.0 > SIGNIFICANT * self.spread

    def left(self, one: Fit) -> float:
        """Return the share of the gap that a fit leaves [1]; zero where what it leaves is not significant."""
        if not self.significant(one):
            return 0.0
        return (self.level(one) - 1.0) / max(self.level(self.nothing) - 1.0, 1e-12)

    def removed(self, before: Fit, after: Fit) -> float:
        """Return the share of what one fit leaves above the floor that another one removes [1]."""
        return (self.level(before) - self.level(after)) / max(self.level(before) - 1.0, 1e-12)

    @property
    def detected(self) -> bool:
        """Whether some effect is worth its numbers beyond what the best of many gains by chance."""
        return any(self.score(one) > DETECTED for one in self.fits)

    def probabilities(self, among: Sequence[Fit]) -> FloatArray:
        """Distribute probability over rival explanations.

        ln p = -(V - V_min) / (2 V_min / N + eps G) - 3 p, with the gap G = V_0 - V_min and eps as the form of the
        effect allows: the stronger the gap, the more of it may be error of form.

        Args:
            among: The rivals; the nominal model may be one of them.

        Returns:
            Probabilities that add up to 1, shape (len(among),).
        """
        levels = np.array([self.level(one) for one in among])
        lowest = float(levels.min())
        gap = max(self.level(self.nothing) - lowest, 0.0)
        temper = np.array([0.0 if not one.predictor.hypothesis else self._temper(one) for one in among])
        costs = np.array([one.predictor.n_effect for one in among])
        logarithm = -(levels - lowest) / (2 * lowest / self.n_values + temper * gap) - PER_PARAMETER * costs
        weights = np.exp(logarithm - logarithm.max())
        probabilities: FloatArray = weights / weights.sum()
        return probabilities

    def _temper(self, one: Fit) -> float:
        plain = all(is_plain(suspect) for suspect in one.predictor.hypothesis)
        return TEMPER_PLAIN if plain else TEMPER_SHAPED


def is_plain(suspect: Suspect) -> bool:
    """Tell whether an effect is a wrong number of the model, without a law of its own."""
    return issubclass(suspect.effect, AbstractChangedValues)
