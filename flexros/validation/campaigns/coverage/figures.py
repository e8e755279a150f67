"""Figures of the repetitions: coverage of the intervals and errors of the values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import binomtest

from flexros.identify.graybox.covariance import NORMAL_95
from flexros.identify.graybox.parameter_scale import parameter_scale

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.robot.robot import Robot


@dataclass(frozen=True)
class Share:
    """A share with its 95 % interval.

    Attributes:
        value: The share [1].
        low: Lower end of the interval [1].
        high: Upper end of the interval [1].
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class ParameterCoverage:
    """One parameter over all repetitions.

    Attributes:
        name: Its name.
        geared: Whether it belongs to a gear rather than to the structure of the arm.
        covered: Share of repetitions whose 95 % interval holds the truth; Wilson interval.
        largest_error: Largest |estimate / truth - 1| where it was not judged not determined [1]; None if never.
        bias: Mean of the errors of logarithms [1].
        spread: Standard deviation of the errors of logarithms [1].
        deviation: Median of the standard deviations that the intervals are made of [1].
        verdicts: Number of repetitions by verdict.
    """

    name: str
    geared: bool
    covered: Share
    largest_error: float | None
    bias: float
    spread: float
    deviation: float
    verdicts: Mapping[str, int]

    @property
    def spring(self) -> bool:
        """Whether it is the stiffness of a spring."""
        return self.name.endswith(".stiffness")


@dataclass(frozen=True)
class WayCoverage:
    """One way to estimate over all repetitions.

    Attributes:
        name: Name of the way.
        parameters: By parameter.
        covered: Share over all parameters and repetitions; the interval comes from the spread between groups, because
            neither parameters nor repetitions with the same phases are independent.
        most_not_determined: Most parameters judged not determined in one repetition.
        unconverged: Fits that did not end at a minimum.
        reduced_cost: Median of the cost over what noise explains.
        factor: Median of the factor on the covariance.
        repetitions: Number of repetitions.
    """

    name: str
    parameters: tuple[ParameterCoverage, ...]
    covered: Share
    most_not_determined: int
    unconverged: int
    reduced_cost: float
    factor: float
    repetitions: int

    def largest_spring_error(self, geared: bool) -> float:
        """Return the largest relative error of gear springs or of arm springs; 0 where none was determined."""
        errors = [one.largest_error for one in self.parameters if one.spring and one.geared == geared]
        return max((error for error in errors if error is not None), default=0.0)


def wilson(hits: int, number: int) -> Share:
    """Return a share with its 95 % score interval (Wilson, 1927).

    Args:
        hits: Number of hits.
        number: Number of trials, at least 1.

    Returns:
        Share and interval.
    """
    interval = binomtest(hits, number).proportion_ci(0.95, method="wilson")
    return Share(hits / number, float(interval.low), float(interval.high))


def way_coverage(
    name: str, groups: Sequence[Sequence[Mapping[str, Any]]], robot: Robot, names: Sequence[str]
) -> WayCoverage:
    """Count over the repetitions of one way.

    Args:
        name: Name of the way.
        groups: Groups of repetitions with the same phases; see
            `flexros.validation.campaigns.coverage.estimates.repetition_estimates` for one entry.
        robot: The truth.
        names: Names of the parameters, length P.

    Returns:
        The figures.
    """
    scale, rows = parameter_scale(robot, names), [row for group in groups for row in group]
    values = np.array([row["values"] for row in rows])
    errors = scale.scaled(values) - scale.scaled(scale.nominal)
    deviations = np.array([row["deviations"] for row in rows])
    covering = np.abs(errors) <= NORMAL_95 * deviations
    verdicts = np.array([row["verdicts"] for row in rows])
    relative = np.where(verdicts == "not_determined", np.nan, np.abs(values / scale.nominal - 1.0))
    geared = _of_gears(robot, names)
    parameters = tuple(
        ParameterCoverage(
            name=parameter,
            geared=bool(geared[place]),
            covered=wilson(int(np.sum(covering[:, place])), len(rows)),
            largest_error=_largest(relative[:, place]),
            bias=float(np.mean(errors[:, place])),
            spread=float(np.std(errors[:, place])),
            deviation=float(np.median(deviations[:, place])),
            verdicts={str(one): int(np.sum(verdicts[:, place] == one)) for one in np.unique(verdicts[:, place])},
        )
        for place, parameter in enumerate(names)
    )
    return WayCoverage(
        name=name,
        parameters=parameters,
        covered=_mean_share(covering.mean(axis=1), [len(group) for group in groups]),
        most_not_determined=int(np.max(np.sum(verdicts == "not_determined", axis=1))),
        unconverged=sum(not row["converged"] for row in rows),
        reduced_cost=float(np.median([row["reduced_cost"] for row in rows])),
        factor=float(np.median([row["factor"] for row in rows])),
        repetitions=len(rows),
    )


def _of_gears(robot: Robot, names: Sequence[str]) -> BoolArray:
    geared = {robot.arm_names[place] for place in robot.gear_rows}
    return np.array([name.rsplit(".", 1)[0] in geared for name in names])


def _largest(errors: FloatArray) -> float | None:
    return float(np.nanmax(errors)) if np.any(np.isfinite(errors)) else None


def _mean_share(shares: FloatArray, sizes: Sequence[int]) -> Share:
    """Return the mean over repetitions, and its interval from the means of groups."""
    mean = float(np.mean(shares))
    means = [float(np.mean(part)) for part in np.split(shares, np.cumsum(sizes)[:-1])]
    reach = NORMAL_95 * float(np.std(means, ddof=1)) / np.sqrt(len(means)) if len(means) > 1 else 1.0
    return Share(mean, float(max(mean - reach, 0.0)), float(min(mean + reach, 1.0)))
