"""Measures of a run of the multivariable benchmark, and their cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.signal import detrend

from flexros.benchmark.measures import AMPLITUDE_WEIGHT, SETTLING_WEIGHT
from flexros.benchmark.multivariable.problem import REST, highest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.benchmark.multivariable.problem import Problem

STILL = 0.1
"""Time over which a value at rest is averaged [s] (chosen)."""
LOST = 1e3
"""Value of every measure of a run that diverges: mm, s and % [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class MotionMeasures:
    """Measures of a run, or the worst ones of several.

    Attributes:
        deflection: Largest distance of the tool from where it was at the start of each window, relative to its
            path [mm], shape (n_windows,).
        settling: Time until it stays within the band about its value at the end of the window, of the windows that
            settle [s], shape (n_settling,).
        noise_torque: Peak-to-peak torque at rest about its trend, largest motor [% of its torque].
        largest_torque: Largest torque, largest motor [% of its torque].
    """

    deflection: FloatArray
    settling: FloatArray
    noise_torque: float
    largest_torque: float

    @property
    def cost(self) -> float:
        """Cost of a model set, with the weights of Paper C on mm, per cent and seconds [1]."""
        sizes = float(np.sum(self.deflection)) + self.noise_torque + self.largest_torque
        return AMPLITUDE_WEIGHT * sizes + SETTLING_WEIGHT * float(np.sum(self.settling))

    def as_dict(self) -> dict[str, Any]:
        """Return the measures for JSON."""
        return {
            "e": [float(value) for value in self.deflection],
            "Ts": [float(value) for value in self.settling],
            "T_NOISE": self.noise_torque,
            "T_MAX": self.largest_torque,
            "V": self.cost,
        }


def measures_of_motion(
    problem: Problem, name: str, error: FloatArray, command: FloatArray, sample_time: float
) -> MotionMeasures:
    """Return the measures of a run.

    Args:
        problem: The problem.
        name: Name of the model set, for the band.
        error: Tool position less that of the undisturbed nominal model [mm], shape (n, 3).
        command: Torques [Nm], shape (n, M).
        sample_time: Time between two samples [s].
    """
    deflection, settling = [], []
    calm = round(STILL / sample_time)
    for window in problem.windows:
        first, last = round(window.start / sample_time), round(window.end / sample_time)
        inside = error[first:last]
        before = np.mean(error[first - calm : first], axis=0)
        deflection.append(float(np.max(np.linalg.norm(inside - before, axis=1))))
        if window.settles:
            away = np.linalg.norm(inside - np.mean(inside[-2 * calm :], axis=0), axis=1) > problem.band[name]
            late = np.flatnonzero(away)
            settling.append((late[-1] + 1) * sample_time if late.size else 0.0)
    share = highest(problem, command)
    rest = detrend(share[round(REST[0] / sample_time) : round(REST[1] / sample_time)], axis=0)
    return MotionMeasures(
        np.array(deflection), np.array(settling), float(np.max(np.ptp(rest, axis=0))), float(np.max(np.abs(share)))
    )


def lost_run(problem: Problem) -> MotionMeasures:
    """Return the measures of a run that diverges."""
    settling = sum(window.settles for window in problem.windows)
    return MotionMeasures(np.full(len(problem.windows), LOST), np.full(settling, LOST), LOST, LOST)


def worst_motion(runs: Sequence[MotionMeasures]) -> MotionMeasures:
    """Return the worst value of each measure."""
    return MotionMeasures(
        np.max([run.deflection for run in runs], axis=0),
        np.max([run.settling for run in runs], axis=0),
        max(run.noise_torque for run in runs),
        max(run.largest_torque for run in runs),
    )


def mean_motion(runs: Sequence[MotionMeasures]) -> MotionMeasures:
    """Return the mean of each measure."""
    return MotionMeasures(
        np.mean([run.deflection for run in runs], axis=0),
        np.mean([run.settling for run in runs], axis=0),
        float(np.mean([run.noise_torque for run in runs])),
        float(np.mean([run.largest_torque for run in runs])),
    )
