"""Equations 8a to 8d of Moberg (2007), Paper B, with their rates replaced by backward differences."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.feedforward.time_stepping.dense_function import dense_function

if TYPE_CHECKING:
    from flexros.feedforward.compensation.arm_forces import ArmForces
    from flexros.feedforward.tool_geometry import ToolGeometry
    from flexros.robot.symbolic.model import SymbolicModel

LARGE_MODEL = 24
"""Number of arm coordinates above which the Newton matrix is M gamma^2 + D gamma + K instead of the exact Jacobian.

The graph of the exact Jacobian grows with some 66 N^2 operations, and the time to compile it accordingly."""


@dataclass(frozen=True)
class DaeEquations:
    """One step of the DAE as CasADi functions (SX, dense).

    The unknowns are z = [q_a, q_m, u_s], shape (N + M,): arm coordinates, motors behind flexible gears, and the torque
    of motors behind stiff gears, which have no coordinate of their own. They are written as a prediction z_0 and a
    small correction x, in which a backward difference formula is affine: z = z_0 + x, v = v_0 + gamma x,
    a = a_0 + gamma^2 x, with gamma [1/s]. The torque contains fourth differences of the output; working on the small
    correction keeps round-off of the large coordinates out of them.

    Attributes:
        n_arm: Number of arm coordinates N.
        n_coordinates: Number of coordinates q = [q_a, q_m].
        n_unknowns: Number of unknowns, N + M.
        n_motors: Number of motors M.
        exact: Whether `newton_matrix` is the exact Jacobian of `residual`.
        residual: (x, z_0, v_0, a_0, gamma, weight, Z) -> residual (N + M,): the arm's equation (8a) times `weight`,
            then Gamma(q_a) - Z (8d).
        newton_matrix: (x, z_0, v_0, a_0, gamma, weight) -> derivative of the residual by x, (N + M, N + M).
        motion: (x, z_0, v_0, a_0, gamma) -> v; motor torque u by equation (2b) and the same differences; load (u
            without the acceleration of the motor's own inertia); momentum of that inertia; encoder position and rate.
    """

    n_arm: int
    n_coordinates: int
    n_unknowns: int
    n_motors: int
    exact: bool
    residual: ca.Function
    newton_matrix: ca.Function
    motion: ca.Function


def arm_residual(
    model: SymbolicModel, q: ca.SX, v: ca.SX, a: ca.SX, u: ca.SX, forces: ArmForces | None = None
) -> ca.SX:
    """Compute the residual force of the arm's equation (2a), zero for a motion that the model allows.

    Args:
        model: The robot's equations.
        q: Coordinates [q_a, q_m], SX.
        v: Rates, SX.
        a: Accelerations, SX.
        u: Motor torques, SX (M, 1); only those behind stiff gears are used.
        forces: Forces of effects on the arm; default: none.

    Returns:
        M_a a_a - c - g - tau_a, SX (N, 1).
    """
    n, p = model.n_arm, model.parameter_values
    effect_force = ca.SX.zeros(n) if forces is None else forces.of(q[:n], v[:n])
    if model.specification.inertial_coupling:
        return (model.mass_matrix(q, p) @ a - model.force(q, v, u, ca.SX.zeros(6), p))[:n] - effect_force
    residual = model.arm_inverse_dynamics(q[:n], v[:n], a[:n], p) - model.transmission_force(
        q[:n], v[:n], q[n:], v[n:], p
    )
    for motor in model.chain.stiff_motors:
        arm = model.chain.gear_rows[motor]
        residual[arm] += model.chain.motor(motor).inertia.value * a[arm] - u[motor]
    return residual - effect_force


def motor_torque(model: SymbolicModel, q: ca.SX, v: ca.SX, a: ca.SX) -> ca.SX:
    """Compute the torque of the motors behind flexible gears from the motor equation (2b).

    Args:
        model: The robot's equations.
        q: Coordinates [q_a, q_m], SX.
        v: Rates, SX.
        a: Accelerations, SX.

    Returns:
        M_m a_m - tau_m, SX (number of motor coordinates, 1).
    """
    n, p = model.n_arm, model.parameter_values
    if model.n_coordinates == n:
        return ca.SX(0, 1)
    if model.specification.inertial_coupling:
        force = model.force(q, v, ca.SX.zeros(model.n_motors), ca.SX.zeros(6), p)
        return (model.mass_matrix(q, p) @ a - force)[n:]
    return model.motor_inertia(p) * a[n:] - model.motor_force(q[:n], v[:n], q[n:], v[n:], p)


def build_equations(
    model: SymbolicModel,
    output: str | None = None,
    exact: bool | None = None,
    geometry: ToolGeometry | None = None,
    forces: ArmForces | None = None,
) -> DaeEquations:
    """Build the functions of one step.

    Args:
        model: The robot's equations, all parameters numbers.
        output: Name of the controlled output; default: that of the robot file.
        exact: Exact Newton matrix, or M gamma^2 + D gamma + K with exact output rows; default: exact up to
            `LARGE_MODEL` arm coordinates.
        geometry: Kinematics of the tool; default: that of the robot file.
        forces: Forces of effects on the arm; default: none.

    Returns:
        The functions.
    """
    exact = model.n_arm <= LARGE_MODEL if exact is None else exact
    n, nq = model.n_arm, model.n_coordinates
    stiff = model.chain.stiff_motors
    x, z_0 = ca.SX.sym("x", nq + len(stiff)), ca.SX.sym("z_0", nq + len(stiff))
    v_0, a_0 = ca.SX.sym("v_0", nq), ca.SX.sym("a_0", nq)
    gamma, weight = ca.SX.sym("gamma"), ca.SX.sym("weight")
    z = z_0 + x
    q, v, a = z[:nq], v_0 + gamma * x[:nq], a_0 + gamma**2 * x[:nq]
    u = ca.SX.zeros(model.n_motors)
    for i, motor in enumerate(stiff):
        u[motor] = z[nq + i]
    if geometry is None:
        value = model.output(output)(q[:n], model.parameter_values)
    else:
        value = geometry.output(output or model.specification.controlled, q[:n])
    Z = ca.SX.sym("Z", value.shape[0])
    residual = ca.vertcat(weight * arm_residual(model, q, v, a, u, forces), value - Z)
    matrix = ca.jacobian(residual, x) if exact else _mass_based_matrix(model, x, q, gamma, weight, value)
    return DaeEquations(
        n_arm=n,
        n_coordinates=nq,
        n_unknowns=z.shape[0],
        n_motors=model.n_motors,
        exact=exact,
        residual=dense_function("residual", [x, z_0, v_0, a_0, gamma, weight, Z], [residual]),
        newton_matrix=dense_function("newton_matrix", [x, z_0, v_0, a_0, gamma, weight], [matrix]),
        motion=dense_function("motion", [x, z_0, v_0, a_0, gamma], [v, *motor_motion(model, q, v, a, u)]),
    )


def motor_motion(model: SymbolicModel, q: ca.SX, v: ca.SX, a: ca.SX, u: ca.SX) -> list[ca.SX]:
    """Compute torque, load, momentum, encoder position and rate of all motors; u holds the torque of stiff gears."""
    n = model.n_arm
    torque, load, momentum = ca.SX(u), ca.SX(u), ca.SX.zeros(model.n_motors)
    inertia = model.motor_inertia(model.parameter_values)
    from_motor = motor_torque(model, q, v, a)
    for i, motor in enumerate(model.chain.flexible_motors):
        torque[motor] = from_motor[i]
        load[motor] = from_motor[i] - inertia[i] * a[n + i]
        momentum[motor] = inertia[i] * v[n + i]
    coordinates = ca.SX.sym("q", model.n_coordinates)
    speed = ca.jacobian(model.encoder(coordinates), coordinates) @ v
    return [torque, load, momentum, model.encoder(q), speed]


def _mass_based_matrix(model: SymbolicModel, x: ca.SX, q: ca.SX, gamma: ca.SX, weight: ca.SX, output: ca.SX) -> ca.SX:
    """Compute M gamma^2 + D gamma + K with exact output rows; neglects how M, c and g depend on position and speed."""
    n, nq, p = model.n_arm, model.n_coordinates, model.parameter_values
    # the springs get symbols of their own, since q and v are expressions of x by which nothing can be differentiated
    position, rate = ca.SX.sym("q", nq), ca.SX.sym("v", nq)
    springs = -model.transmission_force(position[:n], rate[:n], position[n:], rate[n:], p)
    K = ca.substitute(ca.jacobian(springs, position), position, q)
    D = ca.jacobian(springs, rate)
    M = model.mass_matrix(q, p)[:n, :]
    rows = ca.horzcat(M * gamma**2 + D * gamma + K, ca.SX.zeros(n, x.shape[0] - nq))
    for column, motor in enumerate(model.chain.stiff_motors):
        rows[model.chain.gear_rows[motor], nq + column] = -1
    return ca.vertcat(weight * rows, ca.jacobian(output, x))
