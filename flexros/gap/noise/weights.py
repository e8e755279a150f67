"""Weights of prediction errors: what noise alone makes of them, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.gap.noise.encoder_noise import measure_noise
from flexros.record.missing_samples import bridged
from flexros.record.quantization import encoder_quantization
from flexros.record.smoothing import smooth_motion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.noise.encoder_noise import Noise
    from flexros.prediction.observer import ObserverGain
    from flexros.record.quantization import Quantization
    from flexros.record.record import Record
    from flexros.robot import Robot

AS_DECLARED = 0.06
"""Relative difference up to which measured noise counts as that of the robot file [1] (chosen)."""
MEASURED_ERROR, COLOURED_ERROR = 0.01, 0.03
"""Relative error of the variance of measured noise, white and coloured [1] (development seeds)."""
ROUNDING_ERROR = 0.1
"""Relative error of the variance that rounding is taken to add: it is not white where a motor is slow [1] (chosen)."""
OTHERWISE = 0.5
"""Error of the variance of noise over the difference between what a log shows and what is counted with [1] (chosen)."""
COLOURED_BELOW = 0.6
"""Power above the band over that of the declared noise below which the noise is taken for coloured [1] (chosen)."""
LEAST_JITTER = 0.3
"""Least jitter that counts: at the largest speed it adds this share of the encoder noise [1] (chosen)."""
REMEMBERED = 400
"""Samples after which coloured noise has forgotten what drove it (chosen)."""
SMOOTH_CUTOFF = 40.0
"""Highest frequency of the motion whose speed tells what jitter does [Hz] (chosen)."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """What the encoders of a log do to a position.

    Attributes:
        deviation: Standard deviation of the noise [rad or m], quantization included, shape (M,).
        whitening: Filter 1 + a_1 z^-1 + ... that makes the noise white, per motor, shape (M, order + 1).
        driving: Standard deviation of that white noise [rad or m], shape (M,).
        jitter: Standard deviation of the sampling instants [s].
        quantizations: Encoders whose rounding matters.
        rounding: Largest share of rounding in the variance of the noise of an encoder [1].
        floor_error: Relative standard deviation of the variance of the noise [1]; zero where it is as declared.
        doubt: The same by which noise may be other than declared in this very log, so that a gap of that size is none
            [1].
        signal_tolerance: Share of the rms of a torque that counts as no gap [1].
        warnings: What was noticed, a sentence each.
    """

    deviation: FloatArray
    whitening: FloatArray
    driving: FloatArray
    jitter: float
    quantizations: tuple[Quantization, ...]
    rounding: float
    floor_error: float
    doubt: float
    signal_tolerance: float
    warnings: tuple[str, ...]


def measurement_of(record: Record, robot: Robot) -> Measurement:
    """Find out what the encoders of a log do.

    Noise that is as the robot file declares it is taken from there, which is the more exact. A log without rest shows
    noise above the band of the motion only: where that is far less than declared, it is taken for the upper end of a
    first-order autoregression a of the declared power, which has the share (1 - a) / (1 + a) of it at half the
    sampling rate.

    Args:
        record: The log.
        robot: The nominal robot.

    Raises:
        InputError: There is no noise.
    """
    noise = measure_noise(record, robot)
    declared = robot.encoder_noise
    autoregression = np.zeros((robot.n_motors, max(1, noise.autoregression.shape[1])))
    autoregression[:, : noise.autoregression.shape[1]] = noise.autoregression
    if not np.all((declared > 0) & (noise.standard_deviation > 0)):
        raise InputError(
            f"{record.name}: robot {robot.name} states encoder noise of {declared.tolist()} rad or m and the log shows "
            f"{noise.standard_deviation.tolist()}, but both must be above zero, or nothing can be told from noise; "
            "give sensors.encoder_noise in the robot file"
        )
    near = np.abs(noise.standard_deviation / declared - 1) < AS_DECLARED
    deviation = np.where(near, declared, noise.standard_deviation)
    for motor, source in enumerate(noise.source):
        share = float((noise.standard_deviation[motor] / declared[motor]) ** 2)
        if source == "above the band" and share < COLOURED_BELOW and not np.any(autoregression[motor]):
            deviation[motor], autoregression[motor, 0] = declared[motor], (1 - share) / (1 + share)
    quantizations = encoder_quantization(record, robot)
    for one in quantizations:
        deviation[one.motor] = np.hypot(declared[one.motor], one.step / np.sqrt(12))
    rounding = max((1 - (declared[one.motor] / deviation[one.motor]) ** 2 for one in quantizations), default=0.0)
    coloured = bool(np.any(autoregression))
    error = COLOURED_ERROR if coloured else 0.0 if bool(np.all(near)) else MEASURED_ERROR
    whitening = np.hstack([np.ones((robot.n_motors, 1)), -autoregression[:, : None if coloured else 0]])
    return Measurement(
        deviation=deviation,
        whitening=whitening,
        driving=deviation / np.array([_amplification(row) for row in whitening]),
        jitter=noise.jitter,
        quantizations=quantizations,
        rounding=float(rounding),
        floor_error=float(np.hypot(error, ROUNDING_ERROR * rounding)),
        doubt=0.0 if coloured else _doubt(noise, deviation),
        signal_tolerance=noise.signal_tolerance,
        warnings=noise.warnings,
    )


def measurement_in(record: Record, robot: Robot, measurement: Measurement) -> Measurement:
    """Count with the noise that one log shows in another one of the same robot, whose noise may be a little different.

    Args:
        record: The other log.
        robot: The nominal robot.
        measurement: Noise of the encoders as the one log shows it.
    """
    coloured = measurement.whitening.shape[1] > 1
    doubt = 0.0 if coloured else _doubt(measure_noise(record, robot), measurement.deviation)
    return replace(measurement, doubt=doubt)


def _doubt(noise: Noise, deviation: FloatArray) -> float:
    """Return the error of the variance that the difference between shown and counted noise speaks for [1]."""
    measured = np.array([source != "robot file" for source in noise.source])
    differs = np.where(measured, (noise.standard_deviation / deviation) ** 2 - 1, 0.0)
    return OTHERWISE * float(abs(np.mean(differs)))


def spread_of(record: Record, gain: ObserverGain, measurement: Measurement, *, from_rest: bool = False) -> FloatArray:
    """Compute the standard deviation of every whitened prediction error without gap.

    Args:
        record: The log.
        gain: Gain of the predictor, with the spread that it gives to noise.
        measurement: Noise of the encoders.
        from_rest: Whether the log counts from its first sample; else not until an error of the start has decayed.

    Returns:
        Standard deviations [rad or m], infinite where samples do not count, shape (n, M).
    """
    spread = np.repeat((gain.spread / gain.noise * measurement.driving)[None], record.n_samples, axis=0)
    early = min(gain.settling, record.n_samples if from_rest else record.n_samples // 4)
    if from_rest:
        spread[:early] *= gain.early(early) / gain.spread
    if measurement.jitter > 0:
        position = bridged(record.position, record.valid)
        speed = smooth_motion(position, record.sample_time, min(SMOOTH_CUTOFF, 0.1 / record.sample_time))[1]
        added = np.abs(speed) * measurement.jitter
        if np.any(added.max(axis=0) > LEAST_JITTER * measurement.deviation):
            spread = np.hypot(spread, added * np.sqrt((measurement.whitening**2).sum(axis=1)))
    if not from_rest:
        spread[:early] = np.inf
    spread[: measurement.whitening.shape[1] - 1] = np.inf  # the filter lacks what was before
    missing = ~record.valid
    for later in range(measurement.whitening.shape[1]):  # the filter carries a missing sample on
        spread[np.roll(missing, later)] = np.inf
    return spread


def _amplification(whitening: FloatArray) -> float:
    """Return the standard deviation of coloured noise over that of the white noise that drives it."""
    response = np.zeros(REMEMBERED)
    response[0] = 1.0
    for k in range(1, len(response)):
        past = response[max(0, k - len(whitening) + 1) : k][::-1]
        response[k] = -whitening[1 : 1 + len(past)] @ past
    return float(np.sqrt(np.sum(response**2)))
