"""Largest excitation within the torque limits, estimated before the positions are checked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.control.context import LoopContext
from flexros.identify.design.closed_loop_input import ExperimentConditions, input_spectrum
from flexros.identify.experiment.closed_loop_response import controller_response
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.robot.linear.positions import linearise_positions

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.robot import Robot

CREST = 4.0
"""Largest torque over its rms; that of multisines is below it (chosen)."""


def amplitude_room(
    robot: Robot,
    motor_positions: FloatArray,
    conditions: ExperimentConditions,
    law: AbstractControlLaw,
    sample_time: float,
    torque_share: float,
) -> float:
    """Estimate by what factor the amplitude of all motors may be multiplied.

    Args:
        robot: The robot with its nominal values.
        motor_positions: Motor positions of the experiment [rad or m], shape (Q, M).
        conditions: The excitation.
        law: Controller of the experiment.
        sample_time: Time between two samples [s].
        torque_share: Share of the torque limits that may be reached.

    Returns:
        The factor, by which the torque about gravity reaches the limit at its crest; infinite without limits.
    """
    limits = torque_share * law.command_limits(robot)
    if not np.any(np.isfinite(limits)):
        return np.inf
    positions = linearise_positions(robot, (), motor_positions)
    response = FrequencyModel(positions, conditions.frequency, sample_time, robot.delay).response(positions.values)
    controller = controller_response(law, LoopContext(robot, sample_time), conditions.frequency)
    torque = input_spectrum(response, conditions, controller)
    rms = np.sqrt(conditions.share * np.sum(np.abs(torque) ** 2, axis=1) / 2).max(axis=-1)
    at_rest = np.concatenate([positions.coordinates, np.zeros_like(positions.coordinates)], axis=1)
    holding = np.abs([robot.holding_torque(state) for state in at_rest])
    return float(np.min(np.maximum(limits - holding, 0.0) / (CREST * rms)))
