"""Torque and motion that a reference causes in the linear closed loop, line by line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.control.linear_controller import encoder_controller
from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.control.context import LoopContext
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class ControllerResponse:
    """Frequency responses of a feedback controller about rest, u = to_reference [position; speed] + to_measured y.

    Attributes:
        to_reference: From motor position and speed reference to the torque command, shape (F, M, 2 M).
        to_measured: From the measured motor position to the torque command, shape (F, M, M).
    """

    to_reference: ComplexArray
    to_measured: ComplexArray

    def torque(self, plant: ComplexArray) -> ComplexArray:
        """Close the loop: response from [motor position; speed] reference to the torque command.

        Args:
            plant: Response from torque command to measured motor position, shape (..., F, M, M).

        Returns:
            (I - to_measured plant)^-1 to_reference, shape (..., F, M, 2 M).
        """
        loop = np.eye(plant.shape[-1]) - self.to_measured @ plant
        reference = np.broadcast_to(self.to_reference, (*loop.shape[:-2], *self.to_reference.shape[-2:]))
        return np.asarray(np.linalg.solve(loop, reference), dtype=np.complex128)


def controller_response(law: AbstractControlLaw, context: LoopContext, frequency: FloatArray) -> ControllerResponse:
    """Return the frequency responses of a controller away from its limits.

    Args:
        law: The controller.
        context: Robot, sample time and signals of the loop.
        frequency: Frequencies, above 0 and below half the sampling rate [Hz], shape (F,).

    Returns:
        Its responses.
    """
    linear = encoder_controller(law, context)
    z = np.exp(2j * np.pi * frequency * context.sample_time)[:, None, None]
    entry = np.hstack([linear.state_reference, linear.state_measured])
    memory: ComplexArray = np.linalg.solve(
        z * np.eye(len(linear.state_step)) - linear.state_step, np.broadcast_to(entry, (len(z), *entry.shape))
    )
    whole: ComplexArray = linear.from_state @ memory + np.hstack([linear.from_reference, linear.from_measured])
    references = context.references
    to_reference = [
        references.part(whole[:, :, : references.size], name) for name in ("motor_position", "motor_velocity")
    ]
    return ControllerResponse(np.concatenate(to_reference, axis=-1), whole[:, :, references.size :])


@dataclass(frozen=True, eq=False)
class LoopResponse:
    """Frequency responses of the closed loop from [motor position; speed] reference.

    Attributes:
        torque: To the torque command [Nm or N], shape (F, M, 2 M).
        speed: To the motor speed [rad/s or m/s], shape (F, M, 2 M).
    """

    torque: ComplexArray
    speed: ComplexArray


def loop_response(
    robot: Robot, arm: FloatArray, controller: ControllerResponse, sample_time: float, frequency: FloatArray
) -> LoopResponse:
    """Give torque and motor speed of the closed loop for motor references.

    The robot is linearised at rest. Its response to the held command is that to a continuous one times the response of
    the hold, sin(x) / x with x = w T / 2, and of half a sample and the command's delay; what folds back from above
    the sampling rate is neglected, a relative error of the order (frequency / sampling rate)^2.

    Args:
        robot: The nominal robot.
        arm: Arm coordinates at rest [rad or m], shape (N,).
        controller: Response of the controller at the same frequencies.
        sample_time: Time between two samples [s].
        frequency: Frequencies [Hz], shape (F,).

    Returns:
        The responses.
    """
    linear = linear_model(robot, arm)
    w = (2.0 * np.pi * frequency)[:, None, None]
    moved = np.linalg.solve(
        linear.stiffness + 1j * w * linear.damping - w**2 * linear.mass,
        np.broadcast_to(linear.input, (len(w), *linear.input.shape)),
    )
    hold = np.sinc(frequency * sample_time) * np.exp(-2j * np.pi * frequency * (0.5 * sample_time + robot.delay))
    plant = hold[:, None, None] * (linear.encoder @ moved)
    torque = controller.torque(plant)
    return LoopResponse(torque, 1j * w * (plant @ torque))
