"""The signals of a log in which a gap is looked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.where.bands import OctaveBands, fast_length
from flexros.gap.where.channel import Channel
from flexros.gap.where.motion import motion_of
from flexros.gap.where.order_spectrum import OrderGrid
from flexros.gap.where.regimes import regimes

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.prediction.predicted_log import PredictedLog
    from flexros.gap.where.settings import WhereSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

TOOL_REGIMES = ("all", "standstill", "reversal", "high speed", "vibration", "first third", "last third")
"""Regimes of the tool; those of speed hold when they hold of any motor, standstill when it holds of all."""


def motor_channels(
    prediction: PredictedLog, record: Record, robot: Robot, spectrum: FloatArray, settings: WhereSettings
) -> list[Channel]:
    """Prepare the positions of the motors.

    Args:
        prediction: Of the nominal model.
        record: The log.
        robot: The nominal robot.
        spectrum: Spectrum of the noise by motor, shape (any, M).
        settings: Numbers of the search.
    """
    motion = motion_of(record, robot, prediction.states)
    n = fast_length(record.n_samples)  # the first samples are left out, so that every transform is fast
    bands = OctaveBands.of(n, record.sample_time, settings.lowest_hz)
    valid = (record.valid & (np.arange(record.n_samples) >= prediction.first))[-n:]
    found = []
    for number, joint in enumerate(robot.joint_names):
        masks = {name: mask[-n:] for name, mask in regimes(motion, number, record.sample_time).items()}
        angle, speed = motion.rotor_angle[-n:, number], motion.speed[-n:, number]
        orders = OrderGrid.of(angle, speed, valid, settings.orders)
        estimated = settings.floor == "estimated"
        found.append(Channel(joint, bands, masks, valid, spectrum[:, number], orders, estimated))
    return found


def tool_channels(
    tool_error: FloatArray, record: Record, motors: list[Channel], settings: WhereSettings
) -> list[tuple[Channel, FloatArray]]:
    """Prepare the components of the tool position, each in units of its rms.

    Args:
        tool_error: Measured minus predicted positions [m], shape (n_t, 3).
        record: The log, with the times of the tool.
        motors: The channels of the motors, whose regimes are used.
        settings: Numbers of the search.

    Returns:
        Channels and values of the components that are not zero all the time.
    """
    assert record.tool is not None
    time = record.tool.time
    sample_time = float(time[-1] - time[0]) / max(len(time) - 1, 1)
    bands = OctaveBands.of(fast_length(len(time)), sample_time, settings.lowest_hz)
    time, tool_error = time[-bands.n_samples :], tool_error[-bands.n_samples :]
    n = motors[0].bands.n_samples
    rows = np.clip(np.round(time / record.sample_time).astype(int) - (record.n_samples - n), 0, n - 1)
    masks = {}
    for name in TOOL_REGIMES:
        every = [channel.masks[channel.regimes.index(name)][rows] > 0 for channel in motors]
        masks[name] = np.all(every, axis=0) if name == "standstill" else np.any(every, axis=0)
    rms = np.sqrt((tool_error**2).mean(axis=0))
    valid = np.ones(len(time), dtype=bool)
    return [
        (Channel("tool", bands, masks, valid, np.ones(2), None, True), tool_error[:, axis] / rms[axis])
        for axis in np.flatnonzero(rms > 0)
    ]
