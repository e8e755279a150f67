"""Sensor noise and disturbances of one seed, pure functions of seed and sample index."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.random_streams import Stream, generator
from flexros.simulate.disturbance import disturbance_signal
from flexros.simulate.sample_blocks import BLOCK, SampleBlocks, Zeros

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.simulate.disturbance import AbstractDisturbance


@dataclass(frozen=True, eq=False)
class PlantSignals:
    """Noise and disturbances by sample index.

    Attributes:
        encoder_noise: Added to the motor positions [rad or m], width M.
        tool_noise: Added to the tool position [m], width 3.
        disturbance: Torque at the motors [Nm or N] (M), then wrench at the tool [N, Nm] (6), width M + 6.
        sensor_errors: Noise and bias added to the values of the further sensors, width n_further.
    """

    encoder_noise: SampleBlocks
    tool_noise: SampleBlocks
    disturbance: SampleBlocks
    sensor_errors: SampleBlocks

    @cached_property
    def measurement_errors(self) -> SampleBlocks:
        """Added to all measurements, encoder values first, width M + n_further."""
        encoder, further = self.encoder_noise, self.sensor_errors
        if not further.width:
            return encoder
        if isinstance(encoder, Zeros) and isinstance(further, Zeros):
            return Zeros(encoder.width + further.width)
        return SampleBlocks(
            lambda number: np.hstack([encoder.block(number), further.block(number)]), encoder.width + further.width
        )


def plant_signals(
    robot: Robot, sample_time: float, seed: int, *, noise: bool, disturbances: Sequence[AbstractDisturbance]
) -> PlantSignals:
    """Generate the signals of a seed.

    Args:
        robot: The robot, with its sensor noise.
        sample_time: Time between two samples [s].
        seed: Seed of noise and random disturbances.
        noise: Whether the sensors have the noise of the robot file.
        disturbances: Torques and forces at motors and tool.

    Raises:
        InputError: A disturbance has an unknown location or a frequency that is too high.
    """
    scale = 1.0 if noise else 0.0
    return PlantSignals(
        encoder_noise=white_noise(scale * robot.encoder_noise, seed, Stream.ENCODER),
        tool_noise=white_noise(np.full(3, scale * robot.tool_noise), seed, Stream.TOOL),
        disturbance=disturbance_signal(disturbances, robot.n_motors, sample_time, seed),
        sensor_errors=_sensor_errors(robot, scale, seed),
    )


def _sensor_errors(robot: Robot, scale: float, seed: int) -> SampleBlocks:
    """Generate noise and bias of the further sensors; the bias stays where the noise is off."""
    sensors = robot.further_sensors
    rms = np.array([scale * sensor.noise for sensor in sensors for _ in sensor.indices])
    bias = np.array([offset for sensor in sensors for offset in sensor.bias])
    noise = white_noise(rms, seed, Stream.FURTHER_SENSORS)
    if not np.any(bias):
        return noise
    return SampleBlocks(lambda number: noise.block(number) + bias, len(bias))


def white_noise(rms: FloatArray, seed: int, stream: Stream) -> SampleBlocks:
    """Generate white normal noise.

    Args:
        rms: Standard deviation of each channel, shape (width,).
        seed: Seed of the run.
        stream: Random stream of the seed.
    """
    width = len(rms)
    if not np.any(rms):
        return Zeros(width)

    def make_block(number: int) -> FloatArray:
        return generator(seed, stream, number).standard_normal((BLOCK, width)) * rms

    return SampleBlocks(make_block, width)
