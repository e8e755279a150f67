"""Statistics of a blind check: shares with intervals, calibration, detection against size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize
from scipy.stats import binomtest

if TYPE_CHECKING:
    from collections.abc import Iterable

    from flexros.arrays import FloatArray

BINS = 10
"""Bins of equal number of cases in the calibration."""
SMALLEST = 1e-6
"""Smallest probability that the log loss takes seriously: a certain error costs 13.8 nats (chosen)."""


@dataclass(frozen=True)
class Share:
    """A share of cases with its 95 % interval.

    Attributes:
        hits: Cases in which it is so.
        cases: Cases.
        low: Lower end of the interval.
        high: Upper end.
    """

    hits: int
    cases: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The share; nan for no cases."""
        return self.hits / self.cases if self.cases else float("nan")

    def __str__(self) -> str:
        """Write it as people read it."""
        if not self.cases:
            return "no cases"
        return f"{100 * self.value:.1f} % ({100 * self.low:.1f} to {100 * self.high:.1f}), {self.hits} of {self.cases}"


def median(values: Iterable[float | None]) -> float:
    """Return the median of the known values; nan where none is known."""
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else float("nan")


def share(hits: Iterable[bool]) -> Share:
    """Count, with the interval of Wilson (1927) at 95 %.

    Args:
        hits: Whether it is so, for each case.

    Returns:
        The share.
    """
    values = [bool(hit) for hit in hits]
    k, n = sum(values), len(values)
    if not n:
        return Share(0, 0, 0.0, 1.0)
    interval = binomtest(k, n).proportion_ci(0.95, method="wilson")
    return Share(k, n, float(interval.low), float(interval.high))


@dataclass(frozen=True)
class Calibration:
    """Calibration of the reported probabilities.

    Attributes:
        stated: Mean probability of each bin.
        true: Share that was right in each bin.
        count: Cases of each bin.
        error: Expected calibration error, the mean distance of both weighted by the cases.
        log_loss: Mean of -ln of the probability given to what was so [nats].
    """

    stated: tuple[float, ...]
    true: tuple[float, ...]
    count: tuple[int, ...]
    error: float
    log_loss: float


def calibration(probability: FloatArray, right: FloatArray) -> Calibration | None:
    """Compare stated probabilities with what was so.

    Args:
        probability: Stated probabilities, shape (n,).
        right: 1 where it was so, else 0, shape (n,).

    Returns:
        The calibration in bins of equal numbers of cases; None for no cases.
    """
    if not len(probability):
        return None
    order = np.argsort(probability, kind="stable")
    parts = [part for part in np.array_split(order, BINS) if len(part)]
    stated = [float(np.mean(probability[part])) for part in parts]
    true = [float(np.mean(right[part])) for part in parts]
    count = [len(part) for part in parts]
    error = float(np.average(np.abs(np.subtract(stated, true)), weights=count))
    p = np.clip(np.where(right > 0.5, probability, 1 - probability), SMALLEST, 1.0)
    return Calibration(tuple(stated), tuple(true), tuple(count), error, float(-np.mean(np.log(p))))


@dataclass(frozen=True)
class DetectionCurve:
    """Share of detected cases over their size.

    Attributes:
        centre: Gain in log-likelihood at which a half is found [nats]; nan where the cases do not determine it.
        slope: Steepness, per factor e of the gain.
        at_90: Gain at which 90 % are found [nats].
        cases: Cases.
    """

    centre: float
    slope: float
    at_90: float
    cases: int

    def value(self, gain: FloatArray) -> FloatArray:
        """Evaluate the curve at gains [nats], shape (n,)."""
        return np.asarray(1 / (1 + np.exp(-self.slope * (np.log(gain) - np.log(self.centre)))))


def detection_curve(gain: FloatArray, found: FloatArray) -> DetectionCurve:
    """Fit a logistic curve over the logarithm of the size, with a weak prior that keeps it finite.

    Args:
        gain: Expected gains in log-likelihood [nats], shape (n,).
        found: 1 where the case was found, else 0, shape (n,).

    Returns:
        The curve; its centre is nan where all or none were found.
    """
    if not len(gain) or found.min() == found.max():
        return DetectionCurve(float("nan"), float("nan"), float("nan"), len(gain))
    x = np.log(np.maximum(gain, 1e-3))

    def loss(parameters: FloatArray) -> float:
        centre, slope = parameters[0], np.exp(parameters[1])
        z = np.clip(slope * (x - centre), -500, 500)
        return float(np.sum(np.logaddexp(0, z) - found * z) + 0.05 * parameters[1] ** 2 + 1e-3 * (centre - 4) ** 2)

    fit = minimize(loss, np.array([4.0, 0.0]), method="Nelder-Mead", options={"maxiter": 2000})
    centre, slope = float(fit.x[0]), float(np.exp(fit.x[1]))
    return DetectionCurve(float(np.exp(centre)), slope, float(np.exp(centre + np.log(9) / slope)), len(gain))
