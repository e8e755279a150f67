"""Transmissions between arm and motors: springs, dampers, gears, motor friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot.symbolic.chain import Chain, Joint
    from flexros.robot.symbolic.kinematics import Value


@dataclass(frozen=True)
class Transmission:
    """Forces of springs, dampers and motor friction, and the motor positions.

    Attributes:
        arm: Force of springs and dampers on the arm coordinates [Nm or N], SX (N, 1).
        motor: Force on the motors' own coordinates without the commanded torque, SX (number of motor coordinates, 1).
        armature: Inertia of rigidly geared motors on the arm coordinates, N entries.
        drive: Matrix from motor torque to arm coordinates (rigid gears), SX (N, M).
        encoder: Motor positions, SX (M, 1).
    """

    arm: ca.SX
    motor: ca.SX
    armature: list[ca.SX]
    drive: ca.SX
    encoder: ca.SX


def build_transmission(chain: Chain, values: Mapping[str, Value], q: ca.SX, v: ca.SX) -> Transmission:
    """Collect the transmissions of a chain (Moberg 2007, eq. 3.18d to 3.18f).

    Args:
        chain: The chain.
        values: Value or symbol of every parameter by name.
        q: Coordinates [q_a, q_m], SX (n_coordinates, 1).
        v: Their rates.

    Returns:
        The transmissions.
    """
    N = len(chain.joints)
    arm = [ca.SX(0)] * N
    motor: list[ca.SX] = []
    armature = [ca.SX(0)] * N
    drive = ca.SX.zeros(N, chain.n_motors)
    encoder: list[ca.SX] = []
    for index, joint in enumerate(chain.joints):
        if joint.motor is None:
            arm[index] = -_spring_damper(joint, values, q[index], v[index])
            continue
        name = f"motor_{joint.motor + 1}"
        friction = values[f"{name}.viscous_friction"]
        if joint.motor_coordinate is None:
            arm[index] = -friction * v[index]
            armature[index] = ca.SX(values[f"{name}.inertia"])
            drive[index, joint.motor] = 1
            encoder.append(q[index])
            continue
        own = N + joint.motor_coordinate
        torque = _spring_damper(joint, values, q[own] - q[index], v[own] - v[index])
        arm[index] = torque
        motor.append(-torque - friction * v[own])
        encoder.append(q[own])
    return Transmission(ca.vertcat(*arm), ca.vertcat(*motor), armature, drive, ca.vertcat(*encoder))


def _spring_damper(joint: Joint, values: Mapping[str, Value], deflection: ca.SX, rate: ca.SX) -> ca.SX:
    spring = joint.direction.spring
    assert isinstance(spring, Spring)
    return spring.force(deflection, values[f"{joint.name}.stiffness"]) + values[f"{joint.name}.damping"] * rate
