"""Torque that a motion of the gears causes in the closed loop with the rigid feedforward."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.control.context import LoopContext
from flexros.identify.experiment.closed_loop_response import ControllerResponse, controller_response, loop_response

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.identify.diagnosis_experiment.scales import Scales
    from flexros.robot import Robot


def torque_response(
    robot: Robot, arm: FloatArray, law: AbstractControlLaw, sample_time: float, scales: Scales, frequency: FloatArray
) -> ComplexArray:
    """Give the response from motor reference to torque command, with the torque of the rigid robot fed forward.

    Args:
        robot: The nominal robot.
        arm: Arm coordinates at rest [rad or m], shape (N,).
        law: The feedback controller.
        sample_time: Time between two samples [s].
        scales: Sizes, with the inertia of the rigid robot.
        frequency: Frequencies [Hz], shape (F,).

    Returns:
        The response [Nm/rad or N/m], shape (F, M, M).
    """
    m, s = robot.n_motors, 2j * np.pi * frequency[:, None, None]
    feedback = controller_response(law, LoopContext(robot, sample_time), frequency)
    position, speed = feedback.to_reference[:, :, :m], feedback.to_reference[:, :, m:]
    whole = position + s * speed + s**2 * scales.inertia
    both = np.concatenate([whole, np.zeros_like(whole)], axis=2)
    response = loop_response(robot, arm, ControllerResponse(both, feedback.to_measured), sample_time, frequency)
    return response.torque[:, :, :m]
