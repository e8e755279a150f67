"""Weights of prediction errors: their standard deviation by noise alone, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.gap.noise.encoder_noise import measure_noise
from flexros.record.balance.joint_assignments import WEIGHTLESS
from flexros.record.checks.checked_record import CheckedRecord
from flexros.record.missing_samples import bridged_motion
from flexros.record.quantization import encoder_quantization, encoder_step
from flexros.record.smoothing import smooth_motion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.noise.encoder_noise import Noise
    from flexros.gap.settings import DiagnosisSettings
    from flexros.prediction.observer import ObserverGain
    from flexros.record.quantization import Quantization
    from flexros.record.record import Record
    from flexros.robot import Robot

UNBELIEVABLE = 3e-9
"""Noise below which positions are no raw ones of an encoder [rad]: the rounding of one with 23 bits per turn of the
motor is 2e-9 rad behind a gear of 100 (chosen)."""
COLOURED_BELOW = 0.6
"""Power above the band over that of the declared noise below which the noise counts as coloured [1] (chosen)."""
LEAST_JITTER = 0.3
"""Least jitter that is used: at the largest speed it adds this share of the encoder noise [1] (chosen)."""
DOMINATES = 3.0
"""Usual noise by uneven instants over that of the encoder from which the gain of the predictor allows for it [1]
(chosen): 5 to 10 on the legs of a quadruped robot, 0.2 to 1.6 on the other measured robots that show it."""
REMEMBERED = 400
"""Samples after which the impulse response of coloured noise has decayed (chosen)."""
LEAST_TORQUE = 0.3
"""Share of the changing torque of the first log that counts at least in another one [1] (chosen)."""
SMOOTH_CUTOFF = 40.0
"""Highest frequency of the motion whose speed the effect of jitter is computed from [Hz] (chosen)."""

MOVED = 1e-3
"""Motion of a joint from which its positions show the noise of an encoder [rad] (chosen): a held one shows none."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """Noise, quantization and jitter of the encoders of a log.

    Attributes:
        deviation: Standard deviation of the noise [rad or m], quantization included, shape (M,).
        whitening: Filter 1 + a_1 z^-1 + ... that whitens the noise, per motor, shape (M, order + 1).
        driving: Standard deviation of that white noise [rad or m], shape (M,).
        jitter: Standard deviation of the sampling instants [s].
        quantizations: Encoders whose quantization matters.
        rounding: Share of quantization in the variance of the noise of each encoder [1], shape (M,).
        floor_error: Relative standard deviation of the variance of the noise, mean over the encoders [1]; zero where it
            is as declared.
        doubt: The same for a deviation of this log's noise from the assumed one; a gap of that size is none [1].
        signal_tolerance: Share of the rms of a torque that counts as no gap [1].
        warnings: Warnings, one sentence each.
        torque: Standard deviation of the torques of the log whose noise this is [Nm or N], shape (M,); None where it
            was not kept.
    """

    deviation: FloatArray
    whitening: FloatArray
    driving: FloatArray
    jitter: float
    quantizations: tuple[Quantization, ...]
    rounding: FloatArray
    floor_error: float
    doubt: float
    signal_tolerance: float
    warnings: tuple[str, ...]
    torque: FloatArray | None = None

    def tolerated_torque(self, record: Record) -> FloatArray:
        """Return the torques of a log that count as no gap [Nm or N], shape (M,).

        They are a share of what changes of a torque. Where that is hardly anything at a motor, as at one that holds a
        constant torque, a share of the torque of the first log counts: its errors are not exact there.

        Args:
            record: The log.
        """
        changing = np.std(record.torque, axis=0)
        least = 0.0 if self.torque is None else LEAST_TORQUE * self.torque
        return np.asarray(self.signal_tolerance * np.maximum(changing, least))

    def uncertain_torque(self, record: Record) -> FloatArray | None:
        """Return the white torque that counts as no gap [Nm or N], shape (M,); None where torques are known exactly.

        Args:
            record: The log.
        """
        if not self.signal_tolerance:
            return None
        tolerated = self.tolerated_torque(record)
        return tolerated if record.torque_noise is None else np.maximum(tolerated, record.torque_noise)


def measurement_of(record: Record, robot: Robot, settings: DiagnosisSettings) -> Measurement:
    """Measure noise, quantization and jitter of the encoders.

    Noise that agrees with the robot file is taken from there, which is more exact. A log without rest shows only the
    noise above the band of the motion. Where that is far below the declared noise, it is taken as the upper end of a
    first-order autoregression a of the declared power, whose share at half the sampling rate is (1 - a) / (1 + a).

    Args:
        record: The log.
        robot: The nominal robot.
        settings: Settings of the diagnosis.

    Raises:
        InputError: There is no noise.
    """
    noise, numbers = measure_noise(record, robot, settings), settings.noise
    stated, declared = robot.encoder_noise > 0, _declared(record, robot, noise)
    quantizations = tuple(one for one in encoder_quantization(record, robot, numbers.coarse_step) if stated[one.motor])
    autoregression = np.zeros((robot.n_motors, max(1, noise.autoregression.shape[1])))
    autoregression[:, : noise.autoregression.shape[1]] = noise.autoregression
    unseen = ~record.predicted & ~(declared > 0)  # its motion drives the model, and no error of it counts
    if np.any(declared > 0):
        declared = np.where(unseen, declared.max(), declared)
    if not np.all((declared > 0) & ((noise.standard_deviation > 0) | ~stated)):
        raise InputError(
            f"{record.name}: robot {robot.name} declares encoder noise of {robot.encoder_noise.tolist()} rad or m and "
            f"the log shows {noise.standard_deviation.tolist()}, but a noise above zero separates a gap from noise; "
            "give sensors.encoder_noise in the robot file"
        )
    near = (np.abs(noise.standard_deviation / declared - 1) < numbers.as_declared) | ~stated
    deviation, measured = np.where(near, declared, noise.standard_deviation), ~near
    for motor, source in enumerate(noise.source):
        share = float((noise.standard_deviation[motor] / declared[motor]) ** 2)
        dim = stated[motor] and source == "above the band" and share < COLOURED_BELOW
        if dim and not np.any(autoregression[motor]):
            deviation[motor], autoregression[motor, 0] = declared[motor], (1 - share) / (1 + share)
            measured[motor] = False
    for one in quantizations:
        if not measured[one.motor]:  # what was measured contains the rounding
            deviation[one.motor] = np.hypot(declared[one.motor], one.step / np.sqrt(12))
    rounding = np.zeros(robot.n_motors)
    for one in quantizations:
        rounding[one.motor] = one.step**2 / 12 / deviation[one.motor] ** 2
    coloured = bool(np.any(autoregression))
    error = numbers.coloured_error if coloured else 0.0 if bool(np.all(near & stated)) else numbers.measured_error
    whitening = np.hstack([np.ones((robot.n_motors, 1)), -autoregression[:, : None if coloured else 0]])
    return Measurement(
        deviation=deviation,
        whitening=whitening,
        driving=deviation / np.array([_amplification(row) for row in whitening]),
        jitter=noise.jitter,
        quantizations=quantizations,
        rounding=rounding,
        floor_error=float(np.hypot(error, numbers.rounding_error * rounding.mean())),
        doubt=0.0 if coloured else numbers.doubt * _difference(noise, deviation),
        signal_tolerance=noise.signal_tolerance,
        warnings=(*noise.warnings, *_undeclared(record, robot, declared)),
        torque=_usual_torque(record, robot, noise.signal_tolerance),
    )


def _usual_torque(record: Record, robot: Robot, tolerance: float) -> FloatArray:
    """Return the standard deviation of the torques of a log [Nm or N], shape (M,), as shares of which errors count.

    A joint without a drive has no torque, known exactly, but weight and inertia are in balance there, and neither is
    known exactly: of a measured log the larger one counts.
    """
    changing: FloatArray = np.std(record.torque, axis=0)
    silent = ~(changing > 0)
    if not tolerance or record.command is not None or not silent.any():
        return changing
    checked = CheckedRecord(record, robot)
    moving = checked.torque_without(WEIGHTLESS)
    parts = np.maximum(np.std(checked.rigid_torque() - moving, axis=0), np.std(moving, axis=0))
    return np.asarray(np.where(silent, parts / LEAST_TORQUE, changing))


def _declared(record: Record, robot: Robot, noise: Noise) -> FloatArray:
    """Return the declared noise; where the robot file declares none, the measured one with rounding."""
    steps = np.array([encoder_step(record, motor) for motor in range(robot.n_motors)])
    measured = np.maximum(noise.standard_deviation, steps / np.sqrt(12))
    return np.where(robot.encoder_noise > 0, robot.encoder_noise, measured)


def _undeclared(record: Record, robot: Robot, used: FloatArray) -> tuple[str, ...]:
    """Say which noise is used for encoders whose robot file declares none."""
    names = [
        f"{name}: {used[motor]:.2g}"
        for motor, name in enumerate(robot.joint_names)
        if not robot.encoder_noise[motor] and record.predicted[motor]
    ]
    if not names:
        return ()
    text = f"the robot file declares no encoder noise, so that of the log is used ({', '.join(names)})"
    quiet = [
        name
        for name, motor, noise, stated in zip(robot.joint_names, robot.motors, used, robot.encoder_noise, strict=True)
        if motor.rotary and not stated and noise < UNBELIEVABLE and np.ptp(record.position[:, motor.index]) > MOVED
    ]
    if not quiet:
        return (text,)
    return (
        text,
        f"the positions of {', '.join(quiet)} have less noise than any encoder: they were low-passed, or a simulator "
        "wrote them without noise. A filter delays them and takes away what is fast, so that delays, lags, springs and "
        "backlash are no findings then, and all errors of the model count far above the noise: log raw positions, or "
        "state the resolution of the encoder as sensors.encoder_noise in the robot file",
    )


def measurement_in(record: Record, robot: Robot, measurement: Measurement, settings: DiagnosisSettings) -> Measurement:
    """Apply the noise estimate of one log to another log of the same robot, allowing a small mismatch.

    Args:
        record: The other log.
        robot: The nominal robot.
        measurement: Noise of the encoders in the one log.
        settings: Settings of the diagnosis.
    """
    coloured = measurement.whitening.shape[1] > 1
    difference = 0.0 if coloured else _difference(measure_noise(record, robot, settings), measurement.deviation)
    return replace(measurement, doubt=settings.noise.doubt * difference)


def _difference(noise: Noise, deviation: FloatArray) -> float:
    """Return the relative difference of the variance between measured and assumed noise, mean over the motors [1]."""
    measured = np.array([source != "robot file" for source in noise.source])
    differs = np.where(measured, (noise.standard_deviation / deviation) ** 2 - 1, 0.0)
    return float(abs(np.mean(differs)))


def spread_of(record: Record, gain: ObserverGain, measurement: Measurement, *, from_rest: bool = False) -> FloatArray:
    """Compute the standard deviation of every whitened prediction error without a gap.

    Args:
        record: The log.
        gain: Gain of the predictor, with the standard deviations of its errors by noise.
        measurement: Noise of the encoders.
        from_rest: Whether the log is used from its first sample; otherwise once an initial-state error has decayed.

    Returns:
        Standard deviations [rad or m], infinite where samples are not used, shape (n, M).
    """
    spread = np.repeat((gain.spread / gain.noise * measurement.driving)[None], record.n_samples, axis=0)
    early = min(gain.settling, record.n_samples if from_rest else record.n_samples // 4)
    if from_rest:
        spread[:early] *= gain.early(early) / gain.spread
    added = off_instants(record, measurement)
    if added is not None:
        # the gain allows for the mean of this noise: what is left of it in the states, and that of the sample itself
        known = np.sqrt(np.maximum(gain.spread**2 - gain.noise**2, 0.0) + measurement.deviation**2)
        spread *= known / measurement.deviation * gain.noise / gain.spread
        spread = np.hypot(spread, added * np.sqrt((measurement.whitening**2).sum(axis=1)))
    if not from_rest:
        spread[:early] = np.inf
    spread[: measurement.whitening.shape[1] - 1] = np.inf  # the filter lacks earlier samples
    missing = ~record.valid
    for later in range(measurement.whitening.shape[1]):  # a missing sample passes through the filter
        spread[np.roll(missing, later)] = np.inf
    return spread


def off_instants(record: Record, measurement: Measurement) -> FloatArray | None:
    """Compute the noise s |q'| of positions that were taken with a deviation s off even instants.

    Args:
        record: The log.
        measurement: Noise of the encoders, with that of the instants.

    Returns:
        Standard deviations [rad or m], shape (n, M); None where they hardly add to the noise of the encoders.
    """
    if measurement.jitter <= 0:
        return None
    position = bridged_motion(record.position, record.valid)
    speed = smooth_motion(position, record.sample_time, min(SMOOTH_CUTOFF, 0.1 / record.sample_time))[1]
    added = np.asarray(np.abs(speed) * measurement.jitter)
    return added if np.any(added.max(axis=0) > LEAST_JITTER * measurement.deviation) else None


def noise_of_positions(record: Record, measurement: Measurement) -> FloatArray:
    """Compute the usual noise of the positions, that of uneven sampling included where that dominates.

    A predictor that trusts positions beyond it takes the errors of their instants for motion: its states follow them,
    and torques that servos make of these states seem to go with small gains and damping. Where the instants add about
    as much as the encoders, the weights allow for them well enough, and a firmer tie shows smaller effects.

    Args:
        record: The log.
        measurement: Noise of the encoders, with that of the instants.

    Returns:
        Standard deviations [rad or m], shape (M,).
    """
    added = off_instants(record, measurement)
    if added is None:
        return measurement.deviation
    usual = np.median(added[record.valid], axis=0)
    if np.max(usual / measurement.deviation) < DOMINATES:
        return measurement.deviation
    return np.asarray(np.hypot(measurement.deviation, usual))


def _amplification(whitening: FloatArray) -> float:
    """Return the standard deviation of coloured noise over that of the white noise that drives it."""
    response = np.zeros(REMEMBERED)
    response[0] = 1.0
    for k in range(1, len(response)):
        past = response[max(0, k - len(whitening) + 1) : k][::-1]
        response[k] = -whitening[1 : 1 + len(past)] @ past
    return float(np.sqrt(np.sum(response**2)))
