"""Decay rates of the closed loop of an experiment, vectorised over positions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.command_delay import split_delay
from flexros.control.context import LoopContext
from flexros.control.linear_controller import encoder_controller
from flexros.robot.linear.held_input import held_input
from flexros.robot.linear.positions import linearise_positions

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.compile.command_delay import CommandDelay
    from flexros.control.base import AbstractControlLaw
    from flexros.control.linear_controller import LinearController
    from flexros.robot import Robot
    from flexros.robot.linear.linearise import LinearModel

_CHUNK = 128
"""Positions that are computed at once."""
_STANDING = 1e-9
"""Eigenvalues this near to 1 do not move: the flag "has begun" of a law."""


def slowest_decay(linear: LinearModel, law: AbstractControlLaw, context: LoopContext, delay: float) -> float:
    """Compute how fast a linear loop forgets.

    Args:
        linear: The robot about a rest.
        law: The control law.
        context: Robot, sample time and signals of the loop.
        delay: Delay of the command at the plant input, any time from zero on [s].

    Returns:
        Decay of the slowest motion [1/s]; negative when the loop is unstable.
    """
    A, B, C, _ = linear.matrices()
    motors = B.shape[1]
    controller = encoder_controller(law, context)
    return float(_decays(A[None], B[None], C[:motors], controller, split_delay(delay, context.sample_time))[0])


def decays_at(
    robot: Robot,
    motor_positions: FloatArray,
    law: AbstractControlLaw,
    sample_time: float,
    progress: Callable[[int], None] | None = None,
) -> FloatArray:
    """Compute how fast the loop forgets at many positions.

    Args:
        robot: The robot with its nominal values.
        motor_positions: Motor positions [rad or m], shape (Q, M).
        law: The control law.
        sample_time: Time between two samples [s].
        progress: Called with the number of positions done.

    Returns:
        Decay of the slowest motion of each [1/s], shape (Q,); negative where the loop is unstable.
    """
    controller = encoder_controller(law, LoopContext(robot, sample_time))
    delay = split_delay(robot.delay, sample_time)
    parts = []
    for begin in range(0, len(motor_positions), _CHUNK):
        at = linearise_positions(robot, (), motor_positions[begin : begin + _CHUNK])
        n = robot.n_coordinates
        pick = np.zeros((robot.n_motors, 2 * n))
        pick[np.arange(robot.n_motors), at.motor_rows] = 1.0
        A = np.zeros((len(at.mass), 2 * n, 2 * n))
        A[:, :n, n:] = np.eye(n)
        A[:, n:] = -np.linalg.solve(at.mass, np.concatenate([at.stiffness, at.damping], axis=2))
        B = np.zeros((len(at.mass), 2 * n, robot.n_motors))
        B[:, n:] = np.linalg.solve(at.mass, np.broadcast_to(pick[:, :n].T, (len(at.mass), n, robot.n_motors)))
        parts.append(_decays(A, B, pick, controller, delay))
        if progress is not None:
            progress(sum(map(len, parts)))
    return np.concatenate(parts)


def _decays(
    A: FloatArray, B: FloatArray, C: FloatArray, controller: LinearController, delay: CommandDelay
) -> FloatArray:
    """Decays of sampled loops of plants A (Q, n, n), B (Q, n, M), C (M, n) with one controller, shape (Q,)."""
    n, m, motors = A.shape[-1], len(controller.state_step), B.shape[-1]
    size = n + m + delay.line_length * motors  # states of the plant, of the controller, commands before, latest first
    commands = np.zeros((delay.line_length + 1, motors, size))  # by age, from the states
    commands[0, :, :n], commands[0, :, n : n + m] = controller.from_measured @ C, controller.from_state
    commands[1:] = np.eye(size)[n + m :].reshape(-1, motors, size)
    plant = np.broadcast_to(np.eye(n, size), (len(A), n, size))
    for piece in delay.pieces:
        step, entry = held_input(A, B, piece.duration)
        plant = step @ plant + entry @ commands[piece.age]
    loop = np.zeros((len(A), size, size))
    loop[:, :n] = plant
    loop[:, n : n + m, :n], loop[:, n : n + m, n : n + m] = controller.state_measured @ C, controller.state_step
    loop[:, n + m :] = commands[:-1].reshape(-1, size)
    radii = np.abs(np.linalg.eigvals(loop))
    largest = np.max(np.where(np.abs(radii - 1.0) > _STANDING, radii, 0.0), axis=-1)
    return np.asarray(-np.log(largest) / delay.sample_time)
