"""Inverse kinematics of the rigid chain: closed form for a two-link elbow, numerical in general."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot.robot import Robot

TOLERANCE = 1e-12
"""Largest remaining error of the output, relative to 1 m + its size [m or rad]."""


def solve(robot: Robot, target: FloatArray, near: FloatArray, output: str | None = None) -> FloatArray:
    """Find arm coordinates with rigid elastic directions, nearest to a given configuration (Moberg 2007, eq. 3.3).

    Args:
        robot: The robot.
        target: Value of the output [m, rad], shape (n_out,).
        near: Arm coordinates to start from, shape (N,); choose the configuration (elbow up or down) by it.
        output: Name of the output; default: the controlled one.

    Returns:
        Arm coordinates [rad or m], shape (N,); directions without motor keep the value 0.

    Raises:
        InputError: The target has the wrong size, is not finite or is out of reach.
    """
    evaluate = robot.model.output_with_slope(output)
    geared = list(robot.chain.geared)
    q = np.zeros(robot.n_arm)
    q[geared] = near[geared]
    n_out = evaluate.size1_out(0)
    if target.shape != (n_out,) or not np.all(np.isfinite(target)):
        raise InputError(
            f"the target {target.tolist()} of output '{output or robot.controlled}' of robot {robot.name} "
            f"must be {n_out} finite numbers; correct it"
        )
    pose = robot.spec.outputs[output or robot.controlled].pose
    angles = [index for index, component in enumerate(pose) if component.startswith("r")]
    error = np.inf
    limit = TOLERANCE * (1.0 + float(np.max(np.abs(target))))
    for _ in range(200):
        value, slope = (np.asarray(part, dtype=float) for part in evaluate(q))
        residual = target - value.ravel()
        residual[angles] = np.remainder(residual[angles] + np.pi, 2 * np.pi) - np.pi  # the short way round
        error = float(np.max(np.abs(residual)))
        if error <= limit:
            return q
        damping = 1e-6 * error if error > 1e-6 else 0.0
        step = _damped_step(slope, residual, damping)
        q[geared] += step * min(1.0, 0.3 / max(float(np.max(np.abs(step))), 1e-300))
    if error <= 1e3 * limit:
        return q
    raise InputError(
        f"the point {np.round(target, 6).tolist()} of output '{output or robot.controlled}' is out of reach of robot "
        f"{robot.name}: the nearest found misses it by {error:.3g} m or rad; move the target"
    )


def _damped_step(slope: FloatArray, residual: FloatArray, damping: float) -> FloatArray:
    """Levenberg-Marquardt step."""
    normal = slope.T @ slope + damping * np.eye(slope.shape[1])
    return np.asarray(np.linalg.lstsq(normal, slope.T @ residual, rcond=None)[0], dtype=float)


def two_link_elbow(l1: float, l2: float, point: FloatArray, configuration: int) -> FloatArray:
    """Closed form for two links, the first along the vertical at zero angle (Moberg 2007, eq. 3.26 to 3.28).

    Args:
        l1: Length of the first link [m].
        l2: Length of the second link [m].
        point: Tool position (p_x, p_y), p_y along the first link at zero angle [m], shape (2,).
        configuration: +1 or -1, the sign in equations 3.27 and 3.28b (elbow up or down).

    Returns:
        Joint angles (q_1, q_2) [rad], shape (2,).

    Raises:
        InputError: The point is out of reach.
    """
    distance = float(np.hypot(point[0], point[1]))
    if not abs(l1 - l2) <= distance <= l1 + l2 or distance == 0:
        raise InputError(
            f"the point {np.round(point, 6).tolist()} is {distance:.6g} m away, but the two links of {l1:g} m "
            f"and {l2:g} m reach from {abs(l1 - l2):g} m to {l1 + l2:g} m; move the point"
        )
    s2 = (l1**2 + l2**2 - distance**2) / (2 * l1 * l2)
    q2 = np.arctan2(s2, configuration * np.sqrt(max(0.0, 1 - s2**2)))
    c_beta = (l1**2 + distance**2 - l2**2) / (2 * l1 * distance)
    beta = np.arctan2(configuration * np.sqrt(max(0.0, 1 - c_beta**2)), c_beta)
    return np.array([np.pi / 2 - np.arctan2(point[1], point[0]) - beta, q2])
