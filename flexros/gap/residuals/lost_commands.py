"""Commands that a log has lost: where the torque that acted is not known, and how long that matters."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.prediction.predictor import Predictor
    from flexros.prediction.observer import ObserverGain
    from flexros.record.record import Record

BETTER = 20.0
"""Fall of the sum of squares by which torques between the neighbours must be better than held ones (chosen)."""
LEAST_LEFT = 0.3
"""Least share of a log that must be left beside what lost commands spoil (chosen)."""


def spoilt_by_lost_commands(record: Record, nominal: Predictor, gain: ObserverGain, start: FloatArray) -> BoolArray:
    """Tell which samples do not count because the torque before them is not known.

    A controller that is late holds its command, a recorder that loses one does not tell it. Where the log has no
    command for long, the torque is not known. Shorter holes are taken for held commands, but for logs that the nominal
    model predicts better with torques interpolated over them: then these were lost too. Behind each lost command the
    predictor needs its time to settle.

    Args:
        record: The log.
        nominal: Predictor of the nominal model.
        gain: Its gain.
        start: State of the robot before the first sample, shape (2 n_coordinates,).

    Returns:
        True where a sample is spoilt, shape (n,).

    Raises:
        InputError: Too little of the log is left.
    """
    late = np.zeros(record.n_samples, dtype=bool) if record.late is None else record.late
    if not late.any():
        return late
    lost = late & ~record.valid
    if np.any(late & ~lost) and _better_between(record, late, nominal, gain, start):
        lost = late
    ends = np.minimum(np.flatnonzero(lost) + gain.settling, record.n_samples)
    steps = np.zeros(record.n_samples + 1)
    np.add.at(steps, np.flatnonzero(lost), 1.0)
    np.add.at(steps, ends, -1.0)
    spoilt: BoolArray = np.cumsum(steps[:-1]) > 0.5
    left = 1 - float(spoilt.mean())
    if left < LEAST_LEFT:
        raise InputError(
            f"{record.name}: {np.count_nonzero(lost)} commands were lost when it was recorded, so that torques which "
            f"acted are not known; the predictor needs {gain.settling * record.sample_time:.2g} s to settle behind "
            f"each, which leaves {100 * left:.0f} % of the log, needed are {100 * LEAST_LEFT:.0f} %: record "
            "joint_commands without losses, e.g. on the machine of the controller"
        )
    return spoilt


def _better_between(record: Record, late: BoolArray, nominal: Predictor, gain: ObserverGain, start: FloatArray) -> bool:
    """Tell whether torques interpolated over short holes predict the log better than held ones."""
    samples, own = np.arange(record.n_samples), ~late
    between = np.stack([np.interp(samples, samples[own], column[own]) for column in record.torque.T], axis=1)
    sums = []
    for torque in (record.torque, between):
        predicted = nominal.predict(np.zeros((0, 1)), replace(record, torque=torque), gain, start)
        errors = predicted.innovation[gain.settling :, :, 0] / gain.spread
        sums.append(float(np.sum(errors**2)))
    return sums[1] < sums[0] - BETTER
