"""Inverse kinematics of the rigid chain: closed form for a two-link elbow, numerical in general."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.errors import InputError
from flexros.robot.parameters import list_parameters
from flexros.robot.symbolic.kinematics import build_geometry

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot.robot import Robot
    from flexros.robot.specification import RobotSpecification
    from flexros.robot.symbolic.chain import Chain

TOLERANCE = 1e-12
"""Largest remaining error of the output, relative to 1 m + its size [m or rad]."""
ELBOW_OUTPUT = ("x", "z")
"""Output components for which a two-link elbow has a closed form."""


def solve(
    robot: Robot, target: FloatArray, near: FloatArray, output: str | None = None, configuration: int | None = None
) -> FloatArray:
    """Compute arm coordinates with rigid elastic directions, nearest to a given configuration (Moberg 2007, eq. 3.3).

    It uses the closed form named in the robot file if the output allows it, and a numerical search otherwise.

    Args:
        robot: The robot.
        target: Value of the output [m, rad], shape (n_out,).
        near: Initial arm coordinates, shape (N,); they select the configuration (elbow up or down).
        output: Name of the output; default: the controlled one.
        configuration: Sign +1 or -1 of a closed form (elbow up or down); default: the one nearest to `near`.

    Returns:
        Arm coordinates [rad or m], shape (N,), zero for directions without motor.

    Raises:
        InputError: The target has the wrong size, is not finite or is out of reach, or the configuration is invalid.
    """
    name = output or robot.controlled
    n_out = robot.model.output_with_slope(name).size1_out(0)
    if target.shape != (n_out,) or not np.all(np.isfinite(target)):
        raise InputError(
            f"the target {target.tolist()} of output '{name}' of robot {robot.name} "
            f"must be {n_out} finite numbers; correct it"
        )
    if robot.elbow_links is not None and robot.spec.outputs[name].pose == ELBOW_OUTPUT:
        return _closed_form(robot, robot.elbow_links, target, near, configuration)
    if configuration is not None:
        raise InputError(
            f"configuration {configuration} was given for output '{name}' of robot {robot.name}, but its solution is "
            "numerical and nearest to a pose; give near instead"
        )
    return _numerical(robot, target, near, name)


def _closed_form(
    robot: Robot, lengths: tuple[float, float], target: FloatArray, near: FloatArray, configuration: int | None
) -> FloatArray:
    """Return the given, else the nearest of the two configurations, with angles within half a turn of a pose."""
    if configuration not in (1, -1, None):
        raise InputError(
            f"configuration is {configuration}, but robot {robot.name} has the configurations 1 and -1 (elbow up or "
            "down); give one of them"
        )
    here = near[list(robot.gear_rows)]
    solutions = []
    for sign in (1, -1) if configuration is None else (configuration,):
        angles = two_link_elbow(*lengths, target, sign)
        solutions.append(angles + 2 * np.pi * np.round((here - angles) / (2 * np.pi)))
    nearest = min(solutions, key=lambda angles: float(np.linalg.norm(angles - here)))
    arm: FloatArray = robot.arm_from_gears(nearest)
    return arm


def _numerical(robot: Robot, target: FloatArray, near: FloatArray, output: str) -> FloatArray:
    """Solve by damped Newton steps from a pose."""
    evaluate = robot.model.output_with_slope(output)
    gears = list(robot.gear_rows)
    q: FloatArray = robot.arm_from_gears(near[gears])
    pose = robot.spec.outputs[output].pose
    angles = [index for index, component in enumerate(pose) if component.startswith("r")]
    error = np.inf
    limit = TOLERANCE * (1.0 + float(np.max(np.abs(target))))
    for _ in range(200):
        value, slope = (np.asarray(part, dtype=float) for part in evaluate(q))
        residual = target - value.ravel()
        residual[angles] = np.remainder(residual[angles] + np.pi, 2 * np.pi) - np.pi  # the shorter way round
        error = float(np.max(np.abs(residual)))
        if error <= limit:
            return q
        damping = 1e-6 * error if error > 1e-6 else 0.0
        step = _damped_step(slope, residual, damping)
        q[gears] += step * min(1.0, 0.3 / max(float(np.max(np.abs(step))), 1e-300))
    if error <= 1e3 * limit:
        return q
    raise InputError(
        f"the point {np.round(target, 6).tolist()} of output '{output}' is out of reach of robot {robot.name}: "
        f"the nearest found misses it by {error:.3g} m or rad; move the target"
    )


def _damped_step(slope: FloatArray, residual: FloatArray, damping: float) -> FloatArray:
    """Return a Levenberg-Marquardt step."""
    normal = slope.T @ slope + damping * np.eye(slope.shape[1])
    return np.asarray(np.linalg.lstsq(normal, slope.T @ residual, rcond=None)[0], dtype=float)


def link_lengths(specification: RobotSpecification, chain: Chain, source: str) -> tuple[float, float]:
    """Return the link lengths l_1 and l_2 [m] of a robot declared as a two-link elbow.

    Args:
        specification: The robot file.
        chain: Its joints.
        source: File or name; prefix of the error message.

    Raises:
        InputError: The chain is not a two-link elbow.
    """
    axes = [(chain.joints[arm].rotary, chain.joints[arm].axis) for arm in chain.gear_rows]
    outputs = [output.pose for output in specification.outputs.values()]
    flat = axes == [(True, 1), (True, 1)] and not chain.turned
    if flat and specification.tool.linear is None and ELBOW_OUTPUT in outputs:
        values = {name: parameter.value for name, parameter in list_parameters(specification).items()}
        geometry = build_geometry(specification, chain, values.__getitem__)
        steps = np.array([ca.DM(step).full().ravel() for step in (*(f.offset for f in geometry.frames), geometry.tool)])
        first, second = (arm + 1 for arm in chain.gear_rows)  # all frames are parallel at zero
        base, upper, fore = (part.sum(axis=0) for part in (steps[:first], steps[first:second], steps[second:]))
        if not base.any() and not upper[:2].any() and not fore[1:].any() and upper[2] > 0 and fore[0] > 0:
            return float(upper[2]), float(fore[0])
    raise InputError(
        f"{source}: inverse_kinematics is 'two_link_elbow', but the chain is not: it must have two motors, both about "
        "y, at zero angle the first link along +z and the second along +x from the base on, and an output "
        "{pose: [x, z]}; correct the bodies, or write inverse_kinematics: numerical"
    )


def two_link_elbow(l1: float, l2: float, point: FloatArray, configuration: int) -> FloatArray:
    """Solve two links in closed form, the first vertical at zero angle (Moberg 2007, eq. 3.26 to 3.28).

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
