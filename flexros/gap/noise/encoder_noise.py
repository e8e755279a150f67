"""Encoder noise of a log: standard deviation at standstill or above the band, colour, jitter of the clock."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.noise.autoregression import TREND, colour_of, without_trend
from flexros.gap.prediction.predictor import Predictor
from flexros.prediction.observer import observer_gain
from flexros.record.missing_samples import bridged_motion, runs
from flexros.record.quantization import encoder_quantization, lattice_step
from flexros.record.smoothing import HIGH_DIFFERENCE, smooth_motion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.settings import DiagnosisSettings, NoiseSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

STILL = 12.0
"""Largest range of the smooth motion over the noise during a standstill; noise may be coloured (chosen)."""
QUIET = 2.0
"""Variance of a standstill over that of the quieter ones above which the motor still moves (chosen)."""
STAMP_STEP = 1e-9
"""Resolution of stamps [s], below which no jitter is told."""
JITTER_SEEN, JITTER_OF_EACH = 4.0, 2.0
"""Slope of the noise power over the squared speed, in standard deviations, from which it is jitter: of all motors
together, and of each (chosen)."""
ROUNDED_SHARE = 0.1
"""Share of rounding in the noise of an encoder from which its jitter is looked for at high speed alone (chosen)."""
CROSSED, SPREAD, FEWEST_BLOCKS = 2.0, 2.5, 20
"""Steps of an encoder that a motor crosses within a sample, from which rounding no longer grows with speed; the factor
by which some blocks must exceed that, and their fewest number (chosen)."""
AT_REST = 0.01
"""Speed over its largest one, rms of a block, up to which a motor rests [1] (chosen)."""
HIDES = 1.2
"""Step of an encoder over its noise above which rounding hides size and colour of the noise [1] (chosen): smaller steps
add white noise of step^2 / 12, with which noise as declared still counts as such."""
RUN_AWAY = 1e3
"""Largest prediction over the largest position; beyond it the prediction has diverged [1] (chosen)."""
MOST_MOVED, LEAST_COLOUR = 1.3, 0.25
"""Noise at standstill over that above the band, and autocorrelation at lag one, up to which additional noise at
standstill counts as motion under control, not as coloured noise (chosen)."""
AS_STATED = 0.05
"""Relative difference of noise above the band from the robot file up to which slow noise at standstill is motion, and
a small difference of noise at standstill is chance (chosen)."""
_BLOCK = 32  # samples over which the power of high differences is averaged
_LOOK = 50.0  # Hz, corner frequency of the motion


@dataclass(frozen=True, eq=False)
class Noise:
    """Encoder noise of a log.

    Attributes:
        standard_deviation: Of each encoder [rad or m], shape (M,).
        autoregression: Coefficients a of e_k = sum a_j e_(k-j) + w_k, shape (M, p); p = 0 for white noise.
        jitter: Standard deviation of the sampling instants about even ones [s].
        source: Source of each standard deviation: "standstill", "above the band" or "robot file", length M.
        signal_tolerance: Share of the rms of a torque that counts as no gap; 0 except for logs of real machines.
        warnings: Warnings, one sentence each.
    """

    standard_deviation: FloatArray
    autoregression: FloatArray
    jitter: float
    source: tuple[str, ...]
    signal_tolerance: float = 0.0
    warnings: tuple[str, ...] = ()


def measure_noise(record: Record, robot: Robot, settings: DiagnosisSettings) -> Noise:
    """Measure the encoder noise; what the log does not show is taken from the robot file.

    Args:
        record: The log.
        robot: The nominal robot, whose file declares the noise.
        settings: Settings of the diagnosis.
    """
    numbers = settings.noise
    position = bridged_motion(record.position, record.valid)
    cutoff = min(_LOOK, 0.1 / record.sample_time)
    smooth, speed, _ = smooth_motion(position, record.sample_time, cutoff)
    M = robot.n_motors
    steps = {one.motor: one.step for one in encoder_quantization(record, robot, numbers.coarse_step)}
    rounded = {motor for motor, step in steps.items() if step > HIDES * robot.encoder_noise[motor]}
    driven = _driven(record, robot, position, settings.level)
    power, jitter = _above_band(position, speed, record)
    constant = np.ptp(position, axis=0) == 0.0
    power[constant] = 0.0  # else numerical errors are left of it
    deviation, colours, source = np.sqrt(power), [np.zeros(0)] * M, ["above the band"] * M
    for motor in range(M):
        rest = None
        if record.predicted[motor] and not constant[motor]:
            rest = _at_standstill(
                position[:, motor], smooth[:, motor], driven[:, motor], record, float(deviation[motor]), numbers
            )
        if motor in rounded and robot.encoder_noise[motor] > 0:
            deviation[motor], source[motor] = robot.encoder_noise[motor], "robot file"
        elif rest is not None:
            stated = float(robot.encoder_noise[motor])
            doubtful = rest[1].size > 0 or abs(rest[0] - stated) < numbers.differs * stated
            if doubtful and abs(deviation[motor] - stated) < AS_STATED * stated:
                continue
            if rest[1].size and (abs(rest[1][0]) > LEAST_COLOUR or rest[0] > MOST_MOVED * deviation[motor]):
                colours[motor] = rest[1]
            elif rest[1].size:
                continue
            deviation[motor], source[motor] = rest[0], "standstill"
        elif not deviation[motor] > 0 and (robot.encoder_noise[motor] > 0 or not record.imported):
            deviation[motor], source[motor] = robot.encoder_noise[motor], "robot file"
        elif not deviation[motor] > 0:
            deviation[motor] = _usual_above_band(position[:, motor])
    kept = _kept_as_stated(deviation, source, robot, numbers) if record.imported else ()
    warnings = (*kept, *_warnings(deviation, colours, jitter, source, robot, numbers))
    order = max(len(colour) for colour in colours)
    return Noise(
        standard_deviation=deviation,
        autoregression=np.stack([np.pad(colour, (0, order - len(colour))) for colour in colours]),
        jitter=jitter,
        source=tuple(source),
        signal_tolerance=0.0 if record.premises.floor_is_noise else numbers.signal_tolerance,
        warnings=warnings,
    )


def _warnings(
    deviation: FloatArray,
    colours: list[FloatArray],
    jitter: float,
    source: list[str],
    robot: Robot,
    numbers: NoiseSettings,
) -> tuple[str, ...]:
    stated = robot.encoder_noise
    differs = [k for k in range(len(stated)) if stated[k] > 0 and abs(deviation[k] / stated[k] - 1) > numbers.differs]
    warnings = []
    for kind in dict.fromkeys(source[motor] for motor in differs):
        own = [motor for motor in differs if source[motor] == kind]
        values = "the measured value is" if len(own) == 1 else "the measured values are"
        warnings.append(
            f"the encoder noise of {', '.join(robot.joint_names[motor] for motor in own)} is "
            f"{_span(deviation[own])} ({kind}), the robot file declares {_span(stated[own])}; {values} used"
        )
    for motor, name in enumerate(robot.joint_names):
        if len(colours[motor]):
            listed = ", ".join(f"{value:.2f}" for value in colours[motor])
            warnings.append(f"the encoder noise of {name} is not white (autoregression {listed})")
    if jitter > 0:
        warnings.append(
            f"the noise of the positions grows with speed, as where they were taken {1e6 * jitter:.3g} us rms off even "
            "instants; stamps need not show it"
        )
    return tuple(warnings)


def _span(values: FloatArray) -> str:
    """Write the smallest and the largest of some values, or the one that all are."""
    low, high = f"{values.min():.3g}", f"{values.max():.3g}"
    return low if low == high else f"{low} to {high}"


def _kept_as_stated(deviation: FloatArray, source: list[str], robot: Robot, numbers: NoiseSettings) -> tuple[str, ...]:
    """Use the declared noise where the log of a real machine shows implausibly little; changes both lists."""
    warnings = []
    for motor, name in enumerate(robot.joint_names):
        stated = float(robot.encoder_noise[motor])
        if deviation[motor] < numbers.implausible * stated:
            warnings.append(
                f"the positions of {name} show a noise of only {deviation[motor]:.2g}, so they were filtered or "
                f"rounded; the {stated:.2g} of the robot file is used"
            )
            deviation[motor], source[motor] = stated, "robot file"
    return tuple(warnings)


def _driven(record: Record, robot: Robot, position: FloatArray, level: float) -> FloatArray:
    """Predict the motor positions by the nominal model [rad or m], shape (n, M); zeros where that diverges."""
    noise = robot.encoder_noise
    if not np.all(noise > 0):
        return np.zeros_like(position)
    start = robot.equilibrium(motor_position=position[0])
    pose = robot.equilibrium(motor_position=np.median(position, axis=0))[: robot.n_arm]
    gain = observer_gain(robot, record.sample_time, level, noise, pose)
    nominal = Predictor(
        RobotWithEffects(robot, ()), (), Tolerance(), record.sample_time, measured_torque=record.measured_torque
    )
    predicted = (
        position
        - nominal.predict(np.zeros((0, 1)), replace(record, position=position), gain, start).innovation[:, :, 0]
    )
    return predicted if np.all(np.abs(predicted) < RUN_AWAY * np.abs(position).max()) else np.zeros_like(position)


def _above_band(position: FloatArray, speed: FloatArray, record: Record) -> tuple[FloatArray, float]:
    """Regress the power of high differences on squared speed: variance of the noise, shape (M,), and jitter [s]."""
    half = len(HIGH_DIFFERENCE) // 2
    n = (len(position) - 2 * half) // _BLOCK * _BLOCK
    rows = slice(half, half + n)
    whole = record.valid[rows].reshape(-1, _BLOCK).all(axis=1)
    variance, slopes, spreads = np.zeros(position.shape[1]), [], []
    for motor, column in enumerate(position.T):
        high = np.convolve(column, HIGH_DIFFERENCE, mode="valid")[:n]
        power = np.mean(high.reshape(-1, _BLOCK) ** 2, axis=1)[whole]
        square = np.mean(speed[rows, motor].reshape(-1, _BLOCK) ** 2, axis=1)[whole]
        variance[motor], slope, spread = _line(square, power)
        moving = square > AT_REST**2 * square.max()
        if moving.sum() >= FEWEST_BLOCKS:  # to a line through much rest all motion is an outlier
            _, slope, spread = _line(square[moving], power[moving])
        step = lattice_step(column[record.valid]) or 0.0
        if step**2 / 12 > ROUNDED_SHARE * variance[motor]:
            crossed = np.sqrt(square) * record.sample_time / step
            crossing = crossed > CROSSED
            if crossing.sum() < FEWEST_BLOCKS or crossed.max() < SPREAD * CROSSED:
                continue
            _, slope, spread = _line(square[crossing], power[crossing])
        slopes.append(slope)
        spreads.append(spread)
    shown = np.array(slopes) / np.maximum(np.array(spreads), 1e-300)
    # a clock jitters for all motors alike; the rest is fast motion of one
    if not (len(shown) and np.all(shown > JITTER_OF_EACH) and np.linalg.norm(shown) > JITTER_SEEN):
        return variance, 0.0
    weight = 1 / np.maximum(np.array(spreads), 1e-300) ** 2
    jitter = float(np.sqrt(max(float(weight @ np.array(slopes) / weight.sum()), 0.0)))
    return variance, jitter if jitter >= STAMP_STEP else 0.0  # less is rounding of numbers


def _usual_above_band(position: FloatArray) -> float:
    """Return the noise in the middle one of all blocks in which the motor moves [rad or m]."""
    high = np.convolve(position, HIGH_DIFFERENCE, mode="valid")
    power = np.mean(high[: len(high) // _BLOCK * _BLOCK].reshape(-1, _BLOCK) ** 2, axis=1)
    moving = power[power > 0]
    return float(np.sqrt(np.median(moving))) if len(moving) else 0.0


def _line(square: FloatArray, power: FloatArray) -> tuple[float, float, float]:
    """Fit power = variance + slope square robustly; return variance, slope and the standard error of the slope.

    Errors are relative to the fit: the power of a block is a mean of squares, so that its deviation grows with it.
    """
    if not np.any(power > 0):
        return 0.0, 0.0, np.inf
    level = float(np.quantile(power[power > 0], 0.3))
    solution, weight, error = np.array([level, 0.0]), np.ones(len(power)), np.inf
    matrix = np.stack([np.ones(len(power)), square], axis=1)
    scale = np.array([1.0, max(float(square.max()), 1e-300)])
    for _ in range(15):
        fitted = np.maximum(matrix @ solution, 0.05 * level + 1e-300)
        off = (power - fitted) / fitted
        spread = max(1.48 * float(np.median(np.abs(off - np.median(off)))), 1e-6)
        weight = np.minimum(1.0, 2.0 * spread / np.maximum(np.abs(off), 1e-12)) / fitted**2
        normal = (matrix / scale).T @ (weight[:, None] * (matrix / scale))
        inverse = np.linalg.pinv(normal, rcond=1e-10)
        solution = inverse @ ((matrix / scale).T @ (weight * power)) / scale
        error = float(np.sqrt(max(inverse[1, 1], 0.0)) * spread / scale[1])
    return float(max(solution[0], 0.0)), float(solution[1]), error


def _at_standstill(
    position: FloatArray,
    smooth: FloatArray,
    driven: FloatArray,
    record: Record,
    rough: float,
    numbers: NoiseSettings,
) -> tuple[float, FloatArray] | None:
    """Measure standard deviation and colour at standstill; None where the motor is not at rest for long enough.

    A controller that responds to the noise moves the motor slightly unless friction holds it. The motion that the model
    predicts from its torques is subtracted where that leaves simpler noise.
    """
    length = max(TREND * 4, round(numbers.still / record.sample_time))
    stretches = []
    for begin, count in zip(*runs(record.valid), strict=True):
        for first in range(int(begin), int(begin + count) - length + 1, length):
            part = slice(first, first + length)
            if np.ptp(smooth[part]) <= STILL * rough and np.ptp(position[part]) > 0:
                stretches.append((without_trend(position[part]), without_trend(driven[part])))
    if len(stretches) * length < numbers.still_samples:
        return None
    noise, moved = (np.stack(part) for part in zip(*stretches, strict=True))
    variance = np.mean(noise**2, axis=1)
    quiet = variance <= QUIET * np.quantile(variance, 0.25)
    _, deviation, colour = min((colour_of(values[quiet]) for values in (noise - moved, noise)), key=lambda fit: fit[0])
    return deviation, colour
