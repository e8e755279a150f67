"""Gear stiffness of a flexible-joint model equivalent to all springs of the arm."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.robot import Robot


def equivalent_compliance(robot: Robot, state: FloatArray, output: str | None = None) -> FloatArray:
    """Compute the compliance of each gear, including the springs of the directions without motor.

    A force F at the controlled output deflects all springs, K dq_a = Gamma_a^T F, and moves the output by
    Gamma_a K^-1 Gamma_a^T F. With elastic directions rigid, the same output is moved by the gears through
    J = Gamma_a restricted to the actuated directions. Seen in gear coordinates the static compliance is

        C = J^-1 Gamma_a K^-1 Gamma_a^T J^-T,

    that is 1/k of each gear plus the contribution of the other springs in the direction of this gear. The
    flexible-joint model represents the diagonal only, which is exact where C is diagonal. For E12 at its initial pose C
    is diagonal with 1/k_1 and 1/k_2 + (0.2 / 1.2)^2 / k_3: body 3 deflects the tool exactly along the motion of gear 2.
    The thesis states only "computed to include k_3 in the best possible way"; this interpretation is chosen.

    Args:
        robot: The robot.
        state: Equilibrium at which the springs are linearised, shape (2 n_coordinates,).
        output: Name of the controlled output; default: that of the robot file.

    Returns:
        Diagonal of C [rad/Nm or m/N], zero for a stiff gear without contribution, shape (M,).

    Raises:
        InputError: A spring has no stiffness there.
    """
    model, n = robot.model, robot.n_arm
    q, rest = ca.SX.sym("q", robot.n_coordinates), ca.SX.zeros(robot.n_coordinates)
    springs = -model.transmission_force(q[:n], rest[:n], q[n:], rest[n:], model.parameter_values)
    stiffness = ca.jacobian(springs, q)[:, :n]
    slope = ca.jacobian(model.output(output)(q[:n], model.parameter_values), q)[:, :n]
    evaluate = ca.Function("springs", [q], [ca.densify(stiffness), ca.densify(slope)])
    K, slopes = (np.array(part) for part in evaluate(state[: robot.n_coordinates]))
    joints = robot.joints
    elastic = robot.spring_rows
    soft = [joints[i].name for i in elastic if not K[i, i] > 0.0]
    if soft:
        raise InputError(
            f"direction {soft[0]} of robot {robot.name} has no stiffness at the start, so there is no equivalent gear "
            "stiffness; give feedforward.stiffness for every motor, or choose another method"
        )
    geared = list(robot.gear_rows)
    own = np.array([1.0 / K[i, i] if i in elastic else 0.0 for i in geared])
    others = [i for i in elastic if i not in geared]
    reflected = np.linalg.pinv(slopes[:, geared]) @ slopes[:, others]
    return np.asarray(own + np.sum(reflected**2 / np.diag(K)[others], axis=1))


def gear_compliance(robot: Robot, state: FloatArray, output: str, given: Mapping[str, float]) -> FloatArray:
    """Return the compliance of each gear: as given by the user, else the equivalent one.

    Args:
        robot: The robot.
        state: Equilibrium at the start, shape (2 n_coordinates,).
        output: Name of the controlled output.
        given: Stiffness by motor name [Nm/rad or N/m].

    Returns:
        Compliance [rad/Nm or m/N], shape (M,); zero for stiff gears.

    Raises:
        InputError: A name is not a motor, or there is no equivalent stiffness.
    """
    for name in given:
        if name not in robot.joint_names:
            raise unknown_name("motor", name, robot.joint_names, "feedforward.stiffness")
    missing = [name for name in robot.joint_names if name not in given]
    compliance = equivalent_compliance(robot, state, output) if missing else np.zeros(robot.n_motors)
    for motor, name in enumerate(robot.joint_names):
        if name in given:
            compliance[motor] = 1.0 / given[name]
        if motor in robot.stiff_motors:
            compliance[motor] = 0.0
    return compliance
