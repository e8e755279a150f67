"""Measures of a run, and the cost of a model set (Moberg 2007, Paper C, sections 5.3 and 5.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.benchmark.disturbances import REST, STEP_WINDOWS, static_torque, window_rows
from flexros.simulate.disturbance import sample_index

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

AMPLITUDE_WEIGHT = 1.259
"""Weight of deflections [1/mm] and torques [1/Nm] in the cost, inferred from Tables 1 and 2 of Paper C."""
SETTLING_WEIGHT = 3.477
"""Weight of the settling times in the cost [1/s], inferred from Tables 1 and 2 of Paper C."""

END = 0.2
"""Part at the end of a window whose mean is the settled deflection [s], chosen."""


@dataclass(frozen=True, eq=False)
class Measures:
    """Measures of one run, or the worst of a set.

    Attributes:
        deflection: Peak-to-peak tool deflection in each window [mm], shape (8,).
        settling: Settling times after the four steps [s], shape (4,).
        noise_torque: Peak-to-peak torque at rest [Nm].
        largest_torque: Largest absolute torque [Nm].
        rms_torque: Root mean square of the torque less what the steps need at rest [Nm].
    """

    deflection: FloatArray
    settling: FloatArray
    noise_torque: float
    largest_torque: float
    rms_torque: float

    @property
    def cost(self) -> float:
        """Cost V of the set [1]."""
        amplitudes = np.sum(self.deflection) + self.noise_torque + self.largest_torque + self.rms_torque
        return float(AMPLITUDE_WEIGHT * amplitudes + SETTLING_WEIGHT * np.sum(self.settling))

    def as_dict(self) -> dict[str, Any]:
        """Return the measures under their names in the paper, for JSON."""
        return {
            "e": self.deflection.tolist(),
            "Ts": self.settling.tolist(),
            "T_NOISE": self.noise_torque,
            "T_MAX": self.largest_torque,
            "T_RMS": self.rms_torque,
            "V": self.cost,
        }


def measures_of_run(deflection: FloatArray, command: FloatArray, band: float, sample_time: float) -> Measures:
    """Measure one run.

    Args:
        deflection: Tool deflection [mm], shape (n,).
        command: Torque command [Nm], shape (n,).
        band: Band of the settling time [mm].
        sample_time: Time between two samples [s].

    Returns:
        The measures; infinite where the run diverged.
    """
    if not (np.all(np.isfinite(deflection)) and np.all(np.isfinite(command))):
        return Measures(np.full(8, np.inf), np.full(4, np.inf), np.inf, np.inf, np.inf)
    windows = [deflection[rows] for rows in window_rows(sample_time)]
    rest = slice(*(sample_index(edge, sample_time) for edge in REST))
    adjusted = command - static_torque(len(command), sample_time)
    return Measures(
        deflection=np.array([np.ptp(window) for window in windows]),
        settling=np.array([_settling(windows[number], band, sample_time) for number in STEP_WINDOWS]),
        noise_torque=float(np.ptp(command[rest])),
        largest_torque=float(np.max(np.abs(command))),
        rms_torque=float(np.sqrt(np.mean(adjusted**2))),
    )


def worst(runs: Sequence[Measures]) -> Measures:
    """Return the largest value of each measure over the models of a set."""
    return Measures(
        deflection=np.max([run.deflection for run in runs], axis=0),
        settling=np.max([run.settling for run in runs], axis=0),
        noise_torque=max(run.noise_torque for run in runs),
        largest_torque=max(run.largest_torque for run in runs),
        rms_torque=max(run.rms_torque for run in runs),
    )


def mean(runs: Sequence[Measures]) -> Measures:
    """Return the mean of each measure over the seeds of the noise."""
    return Measures(
        deflection=np.mean([run.deflection for run in runs], axis=0),
        settling=np.mean([run.settling for run in runs], axis=0),
        noise_torque=float(np.mean([run.noise_torque for run in runs])),
        largest_torque=float(np.mean([run.largest_torque for run in runs])),
        rms_torque=float(np.mean([run.rms_torque for run in runs])),
    )


def oscillation(deflection: FloatArray) -> float:
    """Return the peak-to-peak deflection about its linear trend, in the unit given; infinite if it diverged."""
    if not np.all(np.isfinite(deflection)):
        return float("inf")
    time = np.arange(len(deflection))
    return float(np.ptp(deflection - np.polyval(np.polyfit(time, deflection, 1), time)))


def _settling(window: FloatArray, band: float, sample_time: float) -> float:
    """Return the time from the start of a window until the deflection stays within a band about its end [s]."""
    end = np.mean(window[-sample_index(END, sample_time) :])
    outside = np.flatnonzero(np.abs(window - end) > band)
    return float((outside[-1] + 1) * sample_time) if len(outside) else 0.0
