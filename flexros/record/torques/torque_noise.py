"""White noise of measured torques, which does not act on the robot."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.missing_samples import bridged
from flexros.record.smoothing import HIGH_DIFFERENCE

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record
    from flexros.robot import Robot

STRETCH = 256
"""Samples of the stretches whose spectra are averaged (chosen)."""
FEWEST = 4
"""Fewest stretches that show a spectrum (chosen)."""
BANDS = 16
"""Bands from zero to half the sampling rate; that of least power beside the motion shows white noise alone (chosen)."""
ONE_DEVIATION = 0.6827
"""Share of normal numbers within one standard deviation [1]."""
MATTERS = 0.05
"""Noise over the rms of a torque from which it is taken out [1] (chosen): the share of a torque that counts as no gap
where nothing is stated."""


def without_torque_noise(record: Record, robot: Robot) -> Record:
    """Take white noise out of the torques that a recorder measured (Wiener 1949).

    Such noise does not act on the robot, and a model that takes it for torques predicts better behind a lag, which
    takes some of it away. Of the power density S of a torque the part 1 - s^2 / S is torque, where s^2 is the least one
    of all bands of what is not coherent with the motion: a controller that follows noise of encoders, and a chirp, make
    torques in all bands that act. It is no more than noise of that size usually changes between samples: a few shocks
    have a white spectrum as well, and act.

    Args:
        record: The log, imported from a real machine; commands act with all that is on them, and stay.
        robot: The robot.

    Returns:
        The record, with the noise that it had.
    """
    torque = record.torque if record.noted is None else record.noted
    if not (record.imported and record.measured_torque) or record.n_samples < FEWEST * STRETCH:
        return record
    noise, acting, noted = np.zeros(torque.shape[1]), record.torque.copy(), torque.copy()
    shares: dict[int, float] = {}
    for motor in np.flatnonzero(record.predicted).tolist():
        values = bridged(torque[:, [motor]], record.valid)[:, 0]
        density = _density(values)
        incoherent = density * _incoherent_share(values, bridged(record.position[:, [motor]], record.valid)[:, 0])
        noise[motor] = min(np.sqrt(incoherent.reshape(BANDS, -1).mean(axis=1).min()), _usual(values))
        if noise[motor] > MATTERS * np.std(values):
            shares[motor] = float(noise[motor] / np.std(values))
            passed = np.maximum(1 - noise[motor] ** 2 / density, 0.0)
            acting[:, motor], noted[:, motor] = (_passed(one[:, motor], passed) for one in (acting, noted))
    record = replace(record, torque_noise=noise)
    if not shares:
        return record
    noisy = ", ".join(f"{robot.joint_names[motor]}: {share:.0%}" for motor, share in shares.items())
    text = f"the measured torques have white noise, which is taken out, as it does not act ({noisy} of their rms)"
    return replace(
        record,
        torque=acting,
        noted=None if record.noted is None else noted,
        warnings=(*record.warnings, text),
    )


def _density(values: FloatArray) -> FloatArray:
    """Return the power density from zero to half the sampling rate, of white noise its variance, (STRETCH / 2,)."""
    from scipy.signal import welch  # here, because it loads slowly

    return np.asarray(welch(values, nperseg=STRETCH, detrend="linear")[1][1:] / 2)


def _incoherent_share(values: FloatArray, position: FloatArray) -> FloatArray:
    """Return the share of the power density of a torque that is not coherent with the motion, (STRETCH / 2,).

    Of n averages of independent signals it would be 1 - 1 / n.
    """
    from scipy.signal import coherence

    motion = np.gradient(np.gradient(position))  # about as flat in frequency as the torque
    if not motion.any():
        return np.ones(STRETCH // 2)
    shared = np.nan_to_num(coherence(values, motion, nperseg=STRETCH, detrend="linear")[1][1:])
    averages = 2 * len(values) // STRETCH - 1
    return np.asarray(np.minimum((1 - shared) / (1 - 1 / averages), 1.0))


def _usual(values: FloatArray) -> float:
    """Return the standard deviation of white noise whose high differences are usually as large as those of a signal."""
    return float(np.quantile(np.abs(np.convolve(values, HIGH_DIFFERENCE, "valid")), ONE_DEVIATION))


def _passed(values: FloatArray, share: FloatArray) -> FloatArray:
    """Pass a share of each frequency, without delay; beyond its ends the signal goes on as its mirror image."""
    before, after = 2 * values[0] - values[STRETCH:0:-1], 2 * values[-1] - values[-2 : -STRETCH - 2 : -1]
    spectrum = np.fft.rfft(np.concatenate([before, values, after]))
    known = np.arange(1, len(share) + 1) / len(share)
    spectrum *= np.interp(np.linspace(0, 1, len(spectrum)), known, share, left=1.0)
    return np.asarray(np.fft.irfft(spectrum, len(values) + 2 * STRETCH)[STRETCH:-STRETCH])
