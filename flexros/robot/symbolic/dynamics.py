"""Symbolic dynamics of the chain: recursive Newton-Euler, composite inertia, articulated bodies.

All recursions run in joint coordinates with spatial vectors (angular part first) at the origin of each joint frame.
Notation as in R. Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 5 to 7.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.robot.symbolic.inertial_coupling import solve_symmetric
from flexros.robot.symbolic.kinematics import Mass, joint_origin, joint_rotation, unit_vector

if TYPE_CHECKING:
    from flexros.robot.symbolic.chain import Chain, Joint, LinkMode
    from flexros.robot.symbolic.kinematics import Geometry


@dataclass(frozen=True)
class Motion:
    """Joint frames in motion: rotations to and origins in the frame before, angular and linear velocities."""

    rotations: list[ca.SX]
    origins: list[ca.SX]
    angular: list[ca.SX]
    linear: list[ca.SX]


@dataclass(frozen=True)
class Inertia:
    """Spatial inertia [[A, B], [B^T, C]] that maps velocity to momentum; A and C symmetric, each SX (3, 3)."""

    A: ca.SX
    B: ca.SX
    C: ca.SX


def cross(a: ca.SX, b: ca.SX) -> ca.SX:
    """Return the vector product, SX (3, 1)."""
    return ca.cross(a, b)


def skew(a: ca.SX) -> ca.SX:
    """Return the matrix of the vector product, SX (3, 3)."""
    return ca.skew(a)


def motion(chain: Chain, geometry: Geometry, q: ca.SX, v: ca.SX) -> Motion:
    """Compute the velocities of all joint frames.

    Args:
        chain: The chain.
        geometry: Its geometry.
        q: Arm coordinates, SX (N, 1).
        v: Their rates, SX (N, 1).

    Returns:
        The frames in motion.
    """
    q = geometry.placed(q)
    rotations, origins, angular, linear = [], [], [], []
    omega, velocity = ca.SX.zeros(3), ca.SX.zeros(3)
    for index, joint in enumerate(chain.joints):
        R = joint_rotation(chain, index, q[index])
        r = joint_origin(chain, geometry, index, q[index])
        velocity = R.T @ (velocity + cross(omega, r))
        omega = R.T @ omega
        rate = unit_vector(joint.axis) * v[index]
        if joint.mode is not None:
            turn, shift = _tip_motion(joint.mode, joint, R)
            omega, velocity = omega + turn * v[index], velocity + shift * v[index]
        elif joint.rotary:
            omega = omega + rate
        else:
            velocity = velocity + rate
        rotations.append(R)
        origins.append(r)
        angular.append(omega)
        linear.append(velocity)
    return Motion(rotations, origins, angular, linear)


def _tip_motion(mode: LinkMode, joint: Joint, R: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return turn and displacement of the tip of a link per unit of a mode, in the frame of the tip."""
    return unit_vector(joint.axis) * mode.tip_slope, R.T @ unit_vector(mode.across) * mode.tip


def _momentum(mass: Mass, omega: ca.SX, velocity: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the spatial momentum of a body about the origin of its frame."""
    linear = mass.rigid_mass * (velocity + cross(omega, mass.center))
    return mass.inertia @ omega + cross(mass.center, linear), linear


def _velocity_force(frame: tuple[Mass, ...], omega: ca.SX, velocity: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the bias force V x* (I V) and the friction of the bodies against the surroundings."""
    torque, force = ca.SX.zeros(3), ca.SX.zeros(3)
    for mass in frame:
        angular, linear = _momentum(mass, omega, velocity)
        torque = torque + cross(omega, angular) + cross(velocity, linear) + mass.viscous_friction * omega
        force = force + cross(omega, linear)
    return torque, force


def _bias_acceleration(chain: Chain, index: int, moving: Motion, v: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the velocity-product acceleration V x (S v) of a joint."""
    joint = chain.joints[index]
    rate = unit_vector(joint.axis) * v[index]
    if joint.mode is not None:
        turn, shift = (part * v[index] for part in _tip_motion(joint.mode, joint, moving.rotations[index]))
        omega, velocity = moving.angular[index], moving.linear[index]
        # the displacement is fixed in the frame before: in that of the tip it turns back with the slope
        return cross(omega, turn), cross(omega, shift) + cross(velocity, turn) - cross(turn, shift)
    if joint.rotary:
        return cross(moving.angular[index], rate), cross(moving.linear[index], rate)
    return ca.SX.zeros(3), cross(moving.angular[index], rate)


def _tool_force(geometry: Geometry, moving: Motion, wrench: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the wrench at the tool (base frame, [f; n]) as a spatial force on the last frame."""
    R = ca.SX.eye(3)
    for rotation in moving.rotations:
        R = R @ rotation
    force = R.T @ wrench[:3]
    return R.T @ wrench[3:] + cross(geometry.tool, force), force


def inverse_dynamics(
    chain: Chain, geometry: Geometry, gravity: ca.SX, q: ca.SX, v: ca.SX, a: ca.SX, wrench: ca.SX | None = None
) -> ca.SX:
    """Compute M_a(q) a - c(q, v) - g(q) (Moberg 2007, Paper B, eq. 2a) minus the tool wrench by recursive Newton-Euler.

    Args:
        chain: The chain.
        geometry: Its geometry.
        gravity: Gravity vector [m/s2], SX (3, 1).
        q: Arm coordinates, SX (N, 1).
        v: Their rates.
        a: Their accelerations.
        wrench: Force and torque at the tool in the base frame [N, Nm], SX (6, 1); None for none.

    Returns:
        Generalised force at the joints [Nm or N], SX (N, 1).
    """
    moving = motion(chain, geometry, q, v)
    n = len(chain.joints)
    torques: list[ca.SX] = []
    forces: list[ca.SX] = []
    bending = [ca.SX(0)] * n
    alpha, accel = ca.SX.zeros(3), -gravity
    for index, joint in enumerate(chain.joints):
        R, r = moving.rotations[index], moving.origins[index]
        extra_angular, extra_linear = _bias_acceleration(chain, index, moving, v)
        accel = R.T @ (accel + cross(alpha, r)) + extra_linear
        alpha = R.T @ alpha + extra_angular
        step = unit_vector(joint.axis) * a[index]
        if joint.mode is not None:
            turn, shift = _tip_motion(joint.mode, joint, R)
            alpha, accel = alpha + turn * a[index], accel + shift * a[index]
        else:
            alpha, accel = (alpha + step, accel) if joint.rotary else (alpha, accel + step)
        masses = geometry.frames[index].masses
        torque, force = _velocity_force(masses, moving.angular[index], moving.linear[index])
        for mass in masses:
            angular, linear = _momentum(mass, alpha, accel)
            torque, force = torque + angular, force + linear
            if mass.beam:
                frame = _MovingFrame(moving.angular[index], moving.linear[index], alpha, accel)
                angular, linear = _beam_force(mass, frame, q, v, a, bending)
                torque, force = torque + angular, force + linear
        torques.append(torque)
        forces.append(force)
    if wrench is not None:
        torque, force = _tool_force(geometry, moving, wrench)
        torques[-1], forces[-1] = torques[-1] - torque, forces[-1] - force
    result = [ca.SX(0)] * n
    for index in reversed(range(n)):
        joint = chain.joints[index]
        if joint.mode is not None:
            turn, shift = _tip_motion(joint.mode, joint, moving.rotations[index])
            result[index] = bending[index] + ca.dot(turn, torques[index]) + ca.dot(shift, forces[index])
        else:
            result[index] = (torques if joint.rotary else forces)[index][joint.axis]
        if index:
            R, r = moving.rotations[index], moving.origins[index]
            force = R @ forces[index]
            torques[index - 1] = torques[index - 1] + R @ torques[index] + cross(r, force)
            forces[index - 1] = forces[index - 1] + force
    return ca.vertcat(*result)


@dataclass(frozen=True)
class _MovingFrame:
    """Velocities and spatial accelerations of a frame, the latter with gravity as an acceleration of the base."""

    angular: ca.SX
    linear: ca.SX
    alpha: ca.SX
    accel: ca.SX


def _beam_force(
    mass: Mass, frame: _MovingFrame, q: ca.SX, v: ca.SX, a: ca.SX, bending: list[ca.SX]
) -> tuple[ca.SX, ca.SX]:
    """Return torque and force that accelerate the points of a link that bends, and add those on its modes.

    With p the place of a point in the frame: acceleration = accel + omega x velocity + alpha x p
    + omega x (omega x p) + 2 omega x p' + p''.
    """
    omega = frame.angular
    of_frame = frame.accel + cross(omega, frame.linear)
    torque, force = ca.SX.zeros(3), ca.SX.zeros(3)
    for point in mass.beam:
        place = point.at(q)
        turning = cross(frame.alpha, place) + cross(omega, cross(omega, place) + 2 * point.moved(v))
        own = mass.mass * point.share * (of_frame + turning + point.moved(a))
        torque, force = torque + cross(place, own), force + own
        for joint, shape in point.modes:
            bending[joint] = bending[joint] + ca.dot(shape, own)
    return torque, force


def _frame_inertia(masses: tuple[Mass, ...]) -> Inertia:
    A, B, C = ca.SX.zeros(3, 3), ca.SX.zeros(3, 3), ca.SX.zeros(3, 3)
    for mass in masses:
        c = skew(mass.center)
        A = A + mass.inertia - mass.mass * (c @ c)
        B = B + mass.mass * c
        C = C + mass.mass * ca.SX.eye(3)
    return Inertia(A, B, C)


def _to_parent(inertia: Inertia, R: ca.SX, r: ca.SX) -> Inertia:
    """Transform a spatial inertia to the frame before: rotate by R, then shift by r."""
    A, B, C = (R @ block @ R.T for block in (inertia.A, inertia.B, inertia.C))
    x = skew(r)
    shifted = B + x @ C
    return Inertia(A - B @ x + x @ B.T - x @ C @ x, shifted, C)


def inertia_matrix(chain: Chain, geometry: Geometry, q: ca.SX) -> ca.SX:
    """Compute the inertia matrix of the arm M_a(q) by composite rigid bodies.

    Args:
        chain: The chain.
        geometry: Its geometry.
        q: Arm coordinates, SX (N, 1).

    Returns:
        Symmetric matrix [kg m2, kg m, kg], SX (N, N).
    """
    n = len(chain.joints)
    if chain.bends:
        a, rest = ca.SX.sym("a", n), ca.SX.zeros(n)
        matrix = ca.jacobian(inverse_dynamics(chain, geometry, ca.SX.zeros(3), q, rest, a), a)
        return ca.tril2symm(ca.tril(ca.densify(matrix)))
    q = geometry.placed(q)
    rotations = [joint_rotation(chain, i, q[i]) for i in range(n)]
    origins = [joint_origin(chain, geometry, i, q[i]) for i in range(n)]
    M = ca.SX.zeros(n, n)
    composite: Inertia | None = None
    for index in reversed(range(n)):
        own = _frame_inertia(geometry.frames[index].masses)
        if composite is not None:
            child = _to_parent(composite, rotations[index + 1], origins[index + 1])
            own = Inertia(own.A + child.A, own.B + child.B, own.C + child.C)
        composite = own
        torque, force = _column(own, chain, index)
        for ancestor in range(index, -1, -1):
            joint = chain.joints[ancestor]
            M[ancestor, index] = M[index, ancestor] = (torque if joint.rotary else force)[joint.axis]
            force = rotations[ancestor] @ force
            torque = rotations[ancestor] @ torque + cross(origins[ancestor], force)
    return M


def _column(inertia: Inertia, chain: Chain, index: int) -> tuple[ca.SX, ca.SX]:
    """Return the spatial force I S of a unit acceleration of the joint."""
    joint = chain.joints[index]
    if joint.rotary:
        return inertia.A[:, joint.axis], inertia.B.T[:, joint.axis]
    return inertia.B[:, joint.axis], inertia.C[:, joint.axis]


def forward_dynamics(
    chain: Chain,
    geometry: Geometry,
    gravity: ca.SX,
    armature: list[ca.SX],
    q: ca.SX,
    v: ca.SX,
    tau: ca.SX,
    wrench: ca.SX,
) -> ca.SX:
    """Compute the accelerations of the arm by articulated bodies.

    Args:
        chain: The chain.
        geometry: Its geometry.
        gravity: Gravity vector [m/s2], SX (3, 1).
        armature: Additional inertia of each arm coordinate by a rigidly geared motor, length N.
        q: Arm coordinates, SX (N, 1).
        v: Their rates.
        tau: Generalised force at the joints, SX (N, 1).
        wrench: Force and torque at the tool in the base frame [N, Nm], SX (6, 1).

    Returns:
        Accelerations of the arm coordinates, SX (N, 1).
    """
    n = len(chain.joints)
    if chain.bends:
        other = inverse_dynamics(chain, geometry, gravity, q, v, ca.SX.zeros(n), wrench)
        return solve_symmetric(inertia_matrix(chain, geometry, q) + ca.diag(ca.vertcat(*armature)), tau - other)
    moving = motion(chain, geometry, q, v)
    articulated = [_frame_inertia(frame.masses) for frame in geometry.frames]
    bias = [_velocity_force(geometry.frames[i].masses, moving.angular[i], moving.linear[i]) for i in range(n)]
    torque, force = _tool_force(geometry, moving, wrench)
    bias[-1] = (bias[-1][0] - torque, bias[-1][1] - force)
    columns: list[tuple[ca.SX, ca.SX]] = [(ca.SX(), ca.SX())] * n
    pivots: list[ca.SX] = [ca.SX()] * n
    drives: list[ca.SX] = [ca.SX()] * n
    for index in reversed(range(n)):
        joint = chain.joints[index]
        inertia, (torque, force) = articulated[index], bias[index]
        up, down = columns[index] = _column(inertia, chain, index)
        pivots[index] = (up if joint.rotary else down)[joint.axis] + armature[index]
        drives[index] = tau[index] - (torque if joint.rotary else force)[joint.axis]
        if index == 0:
            break
        gain_up, gain_down = up / pivots[index], down / pivots[index]
        rest = Inertia(inertia.A - gain_up @ up.T, inertia.B - gain_up @ down.T, inertia.C - gain_down @ down.T)
        extra_angular, extra_linear = _bias_acceleration(chain, index, moving, v)
        torque = torque + rest.A @ extra_angular + rest.B @ extra_linear + gain_up * drives[index]
        force = force + rest.B.T @ extra_angular + rest.C @ extra_linear + gain_down * drives[index]
        R, r = moving.rotations[index], moving.origins[index]
        moved = _to_parent(rest, R, r)
        before = articulated[index - 1]
        articulated[index - 1] = Inertia(before.A + moved.A, before.B + moved.B, before.C + moved.C)
        force = R @ force
        bias[index - 1] = (bias[index - 1][0] + R @ torque + cross(r, force), bias[index - 1][1] + force)
    return _articulated_accelerations(chain, moving, gravity, columns, pivots, drives, v)


def _articulated_accelerations(
    chain: Chain,
    moving: Motion,
    gravity: ca.SX,
    columns: list[tuple[ca.SX, ca.SX]],
    pivots: list[ca.SX],
    drives: list[ca.SX],
    v: ca.SX,
) -> ca.SX:
    """Compute the last sweep of the articulated body recursion, from base to tool."""
    alpha, accel = ca.SX.zeros(3), -gravity
    result = []
    for index, joint in enumerate(chain.joints):
        R, r = moving.rotations[index], moving.origins[index]
        extra_angular, extra_linear = _bias_acceleration(chain, index, moving, v)
        accel = R.T @ (accel + cross(alpha, r)) + extra_linear
        alpha = R.T @ alpha + extra_angular
        up, down = columns[index]
        a = (drives[index] - ca.dot(up, alpha) - ca.dot(down, accel)) / pivots[index]
        result.append(a)
        step = unit_vector(joint.axis) * a
        alpha, accel = (alpha + step, accel) if joint.rotary else (alpha, accel + step)
    return ca.vertcat(*result)
