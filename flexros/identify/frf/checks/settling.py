"""Check that the recorded periods are steady: a transient decays from period to period."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.estimate.drift import trend_powers

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.frf.experiments import Experiments

MOST_DECAY = 2.0
"""Decay of the change between periods, from the first to the last third of a period, for a warning (chosen)."""


def check_settled(experiments: Experiments, drift_degree: int) -> list[str]:
    """Warn of periods that were recorded before the response was periodic.

    The change from the first to the last period is noise of constant size, or a decaying transient.

    Args:
        experiments: Samples of whole periods.
        drift_degree: Degree of the drift that does not count as a transient.

    Returns:
        Warnings; none with a single period.
    """
    if experiments.n_periods < 2:
        return []
    worst, where = 0.0, ""
    for signals, names, what in (
        (experiments.outputs, experiments.output_names, "position"),
        (experiments.inputs, experiments.input_names, "torque"),
    ):
        decay = _decay(signals, experiments, drift_degree)
        if decay.max() > worst:
            worst, where = float(decay.max()), f"{what} of {names[int(decay.argmax())]}"
    if worst <= MOST_DECAY:
        return []
    return [
        f"{experiments.label}: not settled: the change of the {where} between periods decays {worst:.1f} times within "
        "a period, so the record contains a transient, which counts as noise; add transient_periods, or set method to "
        "local_polynomial, which models it"
    ]


def _decay(signals: FloatArray, experiments: Experiments, drift_degree: int) -> FloatArray:
    """Return the ratio of the rms change in the first and in the last third of a period, shape (n,)."""
    m, _, n = signals.shape
    period = experiments.period
    change = signals[:, -period:] - signals[:, :period]
    flat = np.moveaxis(change, 1, 0).reshape(period, m * n)
    powers = np.hstack([np.ones((period, 1)), trend_powers(period, max(drift_degree - 1, 0))])
    flat = flat - powers @ np.linalg.lstsq(powers, flat, rcond=None)[0]
    spectrum = np.fft.rfft(flat, axis=0)
    spectrum[experiments.excited[-1] + 1 :] = 0
    square = np.fft.irfft(spectrum, n=period, axis=0).reshape(period, m, n) ** 2
    third = period // 3
    first, last = (square[part].mean(axis=(0, 1)) for part in (slice(0, third), slice(period - third, period)))
    size = np.mean(signals**2, axis=(0, 1)) * np.finfo(float).eps ** 1.5
    return np.asarray(np.sqrt((first + size) / (last + size)))
