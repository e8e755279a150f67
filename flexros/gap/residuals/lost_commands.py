"""Lost commands: samples at which the torque that acted is not known, and the time until that has decayed."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.settings import ResidualSettings
    from flexros.prediction.observer import ObserverGain
    from flexros.record.record import Record


def spoilt_by_lost_commands(
    record: Record, nominal: Predictor, gain: ObserverGain, state: FloatArray, settings: ResidualSettings
) -> BoolArray:
    """Find the samples that are not used because the torque before them is not known.

    A controller that is late holds its command; a recorder may lose a command. In long holes the torque is not known.
    Short holes count as held commands, unless the nominal model predicts the log better with torques interpolated over
    them, in which case these commands were lost too. After each lost command the predictor needs time to settle.

    Args:
        record: The log.
        nominal: Predictor of the nominal model.
        gain: Its gain.
        state: State of the robot before the first sample, shape (2 n_coordinates,).
        settings: Settings of the residuals.

    Returns:
        True where a sample is not used, shape (n,).

    Raises:
        InputError: Too little of the log is left.
    """
    late = np.zeros(record.n_samples, dtype=bool) if record.late is None else record.late
    if not late.any():
        return late
    lost = late & ~record.valid
    if np.any(late & ~lost) and _better_interpolated(record, late, nominal, gain, state, settings.lost_commands):
        lost = late
    ends = np.minimum(np.flatnonzero(lost) + gain.settling, record.n_samples)
    steps = np.zeros(record.n_samples + 1)
    np.add.at(steps, np.flatnonzero(lost), 1.0)
    np.add.at(steps, ends, -1.0)
    spoilt: BoolArray = np.cumsum(steps[:-1]) > 0.5
    left = 1 - float(spoilt.mean())
    if left < settings.least_left:
        raise InputError(
            f"{record.name}: {np.count_nonzero(lost)} commands were lost when it was recorded, so that the torques "
            f"that acted are not known; the predictor needs {gain.settling * record.sample_time:.2g} s to settle after "
            f"each, which leaves {100 * left:.0f} % of the log, but {100 * settings.least_left:.0f} % are needed: "
            "record joint_commands without losses, e.g. on the machine of the controller"
        )
    return spoilt


def _better_interpolated(
    record: Record, late: BoolArray, nominal: Predictor, gain: ObserverGain, state: FloatArray, decrease: float
) -> bool:
    """Test whether torques interpolated over short holes predict the log better than held ones."""
    samples, own = np.arange(record.n_samples), ~late
    interpolated = np.stack([np.interp(samples, samples[own], column[own]) for column in record.torque.T], axis=1)
    sums = []
    for torque in (record.torque, interpolated):
        predicted = nominal.predict(np.zeros((0, 1)), replace(record, torque=torque), gain, state)
        errors = predicted.innovation[gain.settling :, :, 0] / gain.spread
        sums.append(float(np.sum(errors**2)))
    return sums[1] < sums[0] - decrease
