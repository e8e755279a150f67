"""Further sensors that contradict the model: a wrong sign, unit or joint is no gap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.missing_samples import bridged_motion
from flexros.record.smoothing import smooth_motion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.residuals.sensor_channel import SensorChannel
    from flexros.record.further_sensors import SensorRecord
    from flexros.record.record import Record
    from flexros.robot import Robot

SEEN = 5.0
"""Extent of a signal over its noise from which it is compared with the model [1] (chosen)."""
ALIKE = 0.5
"""Correlation with the prediction from which a sensor measures what the model predicts [1] (chosen)."""
FACTOR = 3.0
"""Factor between measurement and prediction above which a unit is wrong, not the model [1] (chosen)."""

FORWARDS = 0.3
"""Correlation of the torque that moves the arm with the lead of the link over the motor from which the sign of the
deflection is wrong [1] (chosen)."""
CUTOFF = 10.0
"""Highest frequency of the motion whose torque is computed [Hz]: above it springs of the arm bend (chosen)."""
COMPARED = 2000
"""Samples at which it is (chosen)."""


@dataclass(frozen=True)
class SensorDoubt:
    """What is doubtful of a sensor.

    Attributes:
        text: The sentence.
        contradicts: Whether the sensor cannot measure what its name says, so that it is left out.
    """

    text: str
    contradicts: bool


def doubt_of(
    channel: SensorChannel, predicted: FloatArray, noise: float, record: Record, robot: Robot
) -> SensorDoubt | None:
    """Compare a sensor with what the nominal model predicts.

    Where the model is far off, the torque that moves the arm still tells the sign of a deflection.

    Args:
        channel: The sensor.
        predicted: Prediction of the nominal model, shape (m,).
        noise: Standard deviation of its noise.
        record: The log.
        robot: The nominal robot.

    Returns:
        What is doubtful; None where nothing is.
    """
    used = channel.used
    link, motor = channel.sensor.values, channel.sensor.motor
    if motor is None:
        return _compared(channel, channel.measured[used], predicted[used], noise)
    deflection = predicted if channel.deflection else predicted - motor
    doubt = _compared(channel, link[used], (motor + deflection)[used], noise)
    if doubt is not None and doubt.contradicts:
        return doubt
    doubt = _compared(channel, (link - motor)[used], deflection[used], noise)
    if doubt is None or not robot.motors[channel.sensor.index].flexible:
        return doubt
    forwards = _leads_when_driven(channel.sensor, record, robot)
    if forwards > FORWARDS:
        return SensorDoubt(_opposite(channel), True)
    if doubt.contradicts and forwards < -FORWARDS:
        return SensorDoubt(_little(channel), False)
    return doubt


def _leads_when_driven(sensor: SensorRecord, record: Record, robot: Robot) -> float:
    """Correlate the lead of a link over its motor with the torque that drives the link; a spring makes it negative.

    The torque is that of the rigid bodies in the motion of the measured links, so that stiffness, damping and friction
    of the model do not matter.
    """
    grid = np.arange(record.n_samples) * record.sample_time
    position = bridged_motion(record.position, record.valid).copy()
    for one in record.sensors:
        if one.quantity == "link position":
            position[:, one.index] = np.interp(grid, one.time, one.values)
    motion = smooth_motion(position, record.sample_time, min(CUTOFF, 0.1 / record.sample_time))
    rows = np.linspace(0.05 * record.n_samples, 0.95 * record.n_samples, COMPARED).astype(int)
    arm = np.zeros((3, robot.n_arm, len(rows)))
    arm[:, list(robot.gear_rows)] = motion[:, rows].transpose(0, 2, 1)
    torque = robot.model.arm_inverse_dynamics.map(len(rows))(*arm, np.zeros((0, len(rows)))).full()
    assert sensor.motor is not None
    lead = np.interp(grid[rows], sensor.time, sensor.values - sensor.motor)
    driving = torque[robot.gear_rows[sensor.index]]
    return float(np.corrcoef(driving, lead)[0, 1]) if np.std(driving) > 0 and np.std(lead) > 0 else 0.0


def _opposite(channel: SensorChannel) -> str:
    return (
        f"{channel.sensor.name} is opposite to what the nominal model predicts from the motors, so it is left out; "
        "correct its sign (sign: -1 in the mapping)"
    )


def _little(channel: SensorChannel) -> str:
    return (
        f"{channel.sensor.name} hardly follows what the nominal model predicts from the motors; check its joint, sign "
        "and clock, or the model is far off there"
    )


def _compared(channel: SensorChannel, measured: FloatArray, predicted: FloatArray, noise: float) -> SensorDoubt | None:
    """Compare measured and predicted values by correlation and extent."""
    own, expected = measured - measured.mean(), predicted - predicted.mean()
    extents = float(np.std(own)), float(np.std(expected))
    if max(extents) < SEEN * noise:
        return None
    correlation = float(np.mean(own * expected)) / max(extents[0] * extents[1], 1e-300)
    factor = extents[0] / max(extents[1], 1e-300)
    if correlation < -ALIKE:
        return SensorDoubt(_opposite(channel), True)
    if correlation <= ALIKE:
        return SensorDoubt(_little(channel), False)
    if 1 / FACTOR < factor < FACTOR:
        return None
    return SensorDoubt(
        f"{channel.sensor.name} is {factor:.3g} times what the nominal model predicts from the motors, so it is left "
        "out; check its unit",
        True,
    )
