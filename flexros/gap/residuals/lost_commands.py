"""Samples at which the torque that acted is not known, and what that leaves of the prediction errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.record.missing_samples import bridged_motion, long_holes, runs
from flexros.robot.linear.held_input import held_input
from flexros.robot.linear.linearise import linear_model
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.settings import ResidualSettings
    from flexros.prediction.observer import ObserverGain
    from flexros.record.record import Record
    from flexros.robot import Robot

MOST_DOUBTFUL = 1.0
"""Error by a lost command over the spread of a prediction error above which the sample is not used (chosen)."""

MOST_PREDICTED = 20
"""Most samples in a row through which the prediction goes on with interpolated torques (chosen)."""

LEAST_DOUBTFUL = 0.05
"""The same up to which the spread stays as it is (chosen)."""


@dataclass(frozen=True, eq=False)
class LostCommands:
    """What lost commands leave of a log.

    Attributes:
        record: The log, with torques interpolated where they are not known, and positions in long holes.
        deviation: Standard deviation of the prediction errors by unknown torques and jumps of the clock [rad or m],
            shape (n, M); infinite in long holes and until the prediction has settled behind them.
    """

    record: Record
    deviation: FloatArray

    def spread(self, spread: FloatArray) -> FloatArray:
        """Return the standard deviation of every prediction error, unknown torques included.

        Args:
            spread: The same without them [rad or m], shape (n, M).

        Returns:
            Standard deviations, infinite where the unknown torques dominate, shape (n, M).
        """
        share = self.deviation / np.where(np.isfinite(spread), spread, 1.0)
        wider = np.where(share > LEAST_DOUBTFUL, np.hypot(spread, self.deviation), spread)
        wider[np.any(share > MOST_DOUBTFUL, axis=1)] = np.inf
        return np.asarray(wider)


def lost_commands(
    record: Record,
    nominal: Predictor,
    gain: ObserverGain,
    state: FloatArray,
    pose: FloatArray,
    settings: ResidualSettings,
) -> LostCommands:
    """Find the commands that were lost, and what the unknown torques add to the prediction errors.

    A controller that is late holds its command; a recorder may lose a command. In long holes the torque is not known:
    the prediction is led through them by interpolated positions, and counts again once it has settled. Short holes
    count as held commands, unless the nominal model predicts the log better with torques interpolated over them, in
    which case these commands were lost too. An interpolated torque errs as much as it does where commands are known;
    the error that this leaves in the prediction decays as the error of a state does, and is added to its spread.

    Args:
        record: The log.
        nominal: Predictor of the nominal model.
        gain: Its gain.
        state: State of the robot before the first sample, shape (2 n_coordinates,).
        pose: Arm coordinates at which the gain was computed [rad or m], shape (N,).
        settings: Settings of the residuals.
    """
    late = np.zeros(record.n_samples, dtype=bool) if record.late is None else record.late
    # a measured torque is lost with its sample, though one that is held over a few does no harm
    lost = long_holes(record.valid) if record.measured_torque else late & ~record.valid
    if np.any(late & ~lost) and _better_interpolated(record, late, nominal, gain, state, settings.lost_commands):
        lost = late
    variance = _variance_of_jumps(nominal.robot, record, gain)
    if not lost.any():
        return LostCommands(record, np.sqrt(variance))
    delay = 0.0 if record.measured_torque else nominal.robot.delay / record.sample_time
    begins, lengths = runs(lost)
    for length in np.unique(lengths[lengths <= MOST_PREDICTED]).tolist():
        added = _variance(nominal.robot, record, gain, pose, length, delay)
        for begin in begins[lengths == length].tolist():
            n = min(len(added), record.n_samples - begin)
            variance[begin : begin + n] += added[:n]
    holes = long_holes(~lost, MOST_PREDICTED)
    for begin, length in zip(*runs(holes), strict=True):
        variance[begin : begin + length + int(np.ceil(delay)) + gain.settling] = np.inf
    position = bridged_motion(record.position, ~holes)
    led = replace(record, position=position, bridged=holes) if holes.any() else record
    return LostCommands(_interpolated(led, lost), np.sqrt(variance))


def check_enough_left(record: Record, without: FloatArray, spread: FloatArray, settings: ResidualSettings) -> None:
    """Refuse a log of which unknown torques leave too little.

    Args:
        record: The log.
        without: Standard deviations of the prediction errors without lost commands, shape (n, M).
        spread: The same with them.
        settings: Settings of the residuals.

    Raises:
        InputError: Too little of the log is left.
    """
    before, after = (int(np.all(np.isfinite(values), axis=1).sum()) for values in (without, spread))
    if after >= min(settings.least_left * before, settings.enough_left):
        return
    lost, advice = (
        "commands were lost when it was recorded",
        "joint_commands without losses, e.g. on the machine of the controller",
    )
    if record.measured_torque:
        lost, advice = "samples are missing or the clock jumps", "without such holes"
    raise InputError(
        f"{record.name}: {lost}, so that the torques that acted are not known; where that changes the prediction by no "
        f"more than noise, {after} of {before} samples are left, but {settings.enough_left} or "
        f"{100 * settings.least_left:.0f} % are needed: record {advice}"
    )


def _variance(
    robot: Robot, record: Record, gain: ObserverGain, pose: FloatArray, length: int, delay: float
) -> FloatArray:
    """Compute the variance of the prediction errors from the first of a few lost commands on, shape (k, M).

    The error of the torque has one sign in a short hole.
    """
    A, B, _, _ = linear_model(robot, pose).matrices()
    error = _interpolation_error(record.driving, length)
    if record.command is not None:
        error = error * [robot.parameters[f"{name}.{SERVO}stiffness"].value for name in robot.joint_names]
    states = held_input(A, B[:, : robot.n_motors], record.sample_time)[1] * error
    impulse = []
    for _ in range(min(gain.settling, record.n_samples)):
        impulse.append(gain.readout @ states)
        states = gain.transition @ states
    response = np.stack(impulse)
    total = np.cumsum(np.concatenate([response, np.zeros((length, *response.shape[1:]))]), axis=0)
    total[length:] -= total[:-length].copy()
    errors = np.sum(total**2, axis=2)
    early, late = (np.vstack([np.zeros((1 + int(d), errors.shape[1])), errors]) for d in (delay, np.ceil(delay)))
    return np.asarray(np.maximum(np.vstack([early, np.zeros((len(late) - len(early), early.shape[1]))]), late))


def _variance_of_jumps(robot: Robot, record: Record, gain: ObserverGain) -> FloatArray:
    """Return the squares of the prediction errors behind jumps of the clock [rad2 or m2], shape (n, M).

    What was predicted is late by the motion within the jump, and that decays as an error of a state does.
    """
    variance: FloatArray = np.zeros_like(record.position)
    if record.jumps is None:
        return variance
    steps = np.gradient(record.position, axis=0)
    for begin in np.flatnonzero(record.jumps).tolist():
        state = np.zeros(gain.transition.shape[0])
        for motor, step in enumerate(steps[begin]):
            state[[robot.motor_rows[motor], robot.gear_rows[motor]]] = record.jumps[begin] * step
        for sample in range(begin, min(begin + gain.settling, record.n_samples)):
            variance[sample] += (gain.readout @ state) ** 2
            state = gain.transition @ state
    return variance


def _interpolation_error(torque: FloatArray, length: int) -> FloatArray:
    """Return the rms error of torques interpolated where they are known, shape (M,)."""
    middle = (length + 1) // 2
    if len(torque) < 2 * length + 4:
        return np.asarray(np.ptp(torque, axis=0))
    first, last = torque[: -length - 1], torque[length + 1 :]
    known, share = torque[middle : middle + len(first)], middle / (length + 1)
    return np.asarray(np.sqrt(np.mean((known - (1 - share) * first - share * last) ** 2, axis=0)))


def _interpolated(record: Record, lost: BoolArray) -> Record:
    """Interpolate the torques over lost commands."""
    samples, own = np.arange(record.n_samples), ~lost

    def over(values: FloatArray) -> FloatArray:
        return np.stack([np.interp(samples, samples[own], column[own]) for column in values.T], axis=1)

    command = None if record.command is None else over(record.command)
    noted = None if record.noted is None else over(record.noted)
    return replace(record, torque=over(record.torque), command=command, noted=noted)


def _better_interpolated(
    record: Record, late: BoolArray, nominal: Predictor, gain: ObserverGain, state: FloatArray, decrease: float
) -> bool:
    """Test whether torques interpolated over short holes predict the log better than held ones."""
    sums = []
    for tried in (record, _interpolated(record, late)):
        predicted = nominal.predict(np.zeros((0, 1)), tried, gain, state)
        errors = predicted.innovation[min(gain.settling, record.n_samples // 4) :, :, 0] / gain.spread
        sums.append(float(np.sum(errors**2)))
    return sums[1] < sums[0] - decrease
