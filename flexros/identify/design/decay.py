"""How fast the closed loop of an experiment forgets, at one position or at thousands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from scipy.linalg import expm

from flexros.identify.graybox.linearised_positions import linearise_positions

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.robot import Robot
    from flexros.robot.linearise import LinearModel

_CHUNK = 128
"""Positions that are computed at once."""
_STANDING = 1e-9
"""Eigenvalues this near to 1 do not move: the flag "has begun" of a law."""


def slowest_decay(linear: LinearModel, law: AbstractControlLaw, sample_time: float, delay: float) -> float:
    """Compute how fast a linear loop forgets.

    Args:
        linear: The robot about a rest.
        law: The control law.
        sample_time: Time between two samples [s].
        delay: Delay of the command at the plant input, at most one sample [s].

    Returns:
        Decay of the slowest motion [1/s]; negative when the loop is unstable.
    """
    A, B, C, _ = linear.matrices()
    motors = B.shape[1]
    return float(_decays(A[None], B[None], C[:motors], _slopes(law, motors, sample_time), sample_time, delay)[0])


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
    slopes = _slopes(law, robot.n_motors, sample_time)
    parts = []
    for first in range(0, len(motor_positions), _CHUNK):
        at = linearise_positions(robot, (), motor_positions[first : first + _CHUNK])
        n = robot.n_coordinates
        pick = np.zeros((robot.n_motors, 2 * n))
        pick[np.arange(robot.n_motors), at.motor_places] = 1.0
        A = np.zeros((len(at.mass), 2 * n, 2 * n))
        A[:, :n, n:] = np.eye(n)
        A[:, n:] = -np.linalg.solve(at.mass, np.concatenate([at.stiffness, at.damping], axis=2))
        B = np.zeros((len(at.mass), 2 * n, robot.n_motors))
        B[:, n:] = np.linalg.solve(at.mass, np.broadcast_to(pick[:, :n].T, (len(at.mass), n, robot.n_motors)))
        parts.append(_decays(A, B, pick, slopes, sample_time, robot.delay))
        if progress is not None:
            progress(sum(map(len, parts)))
    return np.concatenate(parts)


def _decays(
    A: FloatArray, B: FloatArray, C: FloatArray, slopes: tuple[FloatArray, ...], sample_time: float, delay: float
) -> FloatArray:
    """Decays of sampled loops of plants A (Q, n, n), B (Q, n, M), C (M, n) and a law with its slopes, shape (Q,)."""
    late, prompt = _held(A, B, delay), _held(A, B, sample_time - delay)
    uc, uy, cc, cy = slopes
    n, m, motors = A.shape[-1], len(cc), B.shape[-1]
    loop = np.zeros((len(A), n + m + motors, n + m + motors))  # states of the plant, of the law, command before
    loop[:, :n, :n] = prompt[0] @ late[0] + prompt[1] @ uy @ C
    loop[:, :n, n : n + m] = prompt[1] @ uc
    loop[:, :n, n + m :] = prompt[0] @ late[1]
    loop[:, n : n + m, :n], loop[:, n : n + m, n : n + m] = cy @ C, cc
    loop[:, n + m :, :n], loop[:, n + m :, n : n + m] = uy @ C, uc
    radii = np.abs(np.linalg.eigvals(loop))
    largest = np.max(np.where(np.abs(radii - 1.0) > _STANDING, radii, 0.0), axis=-1)
    return np.asarray(-np.log(largest) / sample_time)


def _held(A: FloatArray, B: FloatArray, time: float) -> tuple[FloatArray, FloatArray]:
    """Return state transitions and input matrices of a constant input over a time."""
    n, m = B.shape[-2:]
    if time == 0.0:
        return np.broadcast_to(np.eye(n), A.shape), np.zeros_like(B)
    whole = np.zeros((len(A), n + m, n + m))
    whole[:, :n, :n], whole[:, :n, n:] = A, B
    whole = expm(whole * time)
    return whole[:, :n, :n], whole[:, :n, n:]


def _slopes(law: AbstractControlLaw, motors: int, sample_time: float) -> tuple[FloatArray, ...]:
    """Return the derivatives of command and next state with respect to state and measurement, about rest."""
    function = law.function(motors, sample_time)
    c, y = ca.SX.sym("c", function.size1_in("c")), ca.SX.sym("y", motors)
    u, after = function(c, np.zeros(3 * motors), y, law.gains(motors))
    blocks = [ca.densify(ca.jacobian(out, argument)) for out in (u, after) for argument in (c, y)]
    rest = function(law.initial_state(motors), np.zeros(3 * motors), np.zeros(motors), law.gains(motors))[1]
    return tuple(np.asarray(value) for value in ca.Function("slopes", [c, y], blocks)(rest, np.zeros(motors)))
