"""Gears and springs of blind plants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from flexros.robot.parameters import INERTIA_COMPONENTS
from flexros.validation.blind.plant.equations import Equations, InnerState, Twist

if TYPE_CHECKING:
    from collections.abc import Mapping

CORNER = 0.1
"""Width over which a spring bends at its knee, over the knee (chosen)."""


def backlash(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Dead zone with a damped shaft: the exact model of Nordin, Galic and Gutman (1997)."""
    for motor in plant.motors(place):
        joint, twist, half = plant.robot.gear_rows[motor], plant.twist(motor), p["gap"] / 2
        free = ca.SX.sym("free")
        damping = plant.number(joint, "damping")
        slide = twist.rate + plant.spring_torque(joint, twist.angle - free) / damping
        rate = ca.if_else(free >= half, ca.fmin(slide, 0), ca.if_else(free <= -half, ca.fmax(slide, 0), slide))
        plant.states.append(InnerState(free, rate=rate, update=ca.fmin(ca.fmax(free, -half), half)))
        plant.twists[motor] = Twist(twist.angle - free, twist.rate - rate, twist.lever)


def hysteresis(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Bouc-Wen torque over the deflection (Wen 1976, n = 1, beta = gamma)."""
    for motor in plant.motors(place):
        joint, twist = plant.robot.gear_rows[motor], plant.twist(motor)
        share = ca.SX.sym("hysteresis")
        rate = (twist.rate - (ca.fabs(twist.rate) * share + twist.rate * ca.fabs(share)) / 2) / p["angle"]
        plant.states.append(InnerState(share, rate=rate))
        plant.add_spring_torque(joint, p["level"] * share)


def transmission_error(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Error of the gear's ratio that repeats with the turning of the rotor; no power is lost in it."""
    for motor in plant.motors(place):
        twist, angle = plant.twist(motor), plant.angle(motor)
        error = p["amplitude"] * ca.sin(p["order"] * angle + p["phase"])
        own = plant.place(motor)
        slope = ca.jacobian(error, plant.q[own])
        rate = slope * plant.v[own]
        plant.twists[motor] = Twist(twist.angle - error, twist.rate - rate, twist.lever - slope)


def nonlinear_stiffness(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Stiffness that changes beyond a knee, with a rounded corner."""
    joint = plant.joint(place)
    twist, knee = plant.deflection(joint), p["knee"]
    stiffness = plant.spring_torque(joint, knee) / knee

    def beyond(size: ca.SX) -> ca.SX:
        over, width = size - knee, CORNER * knee
        return ca.fmax(over, 0) + width * ca.log1p(ca.exp(-ca.fabs(over) / width))

    extra = beyond(ca.fabs(twist.angle)) - beyond(ca.SX(0))
    plant.add_spring_torque(joint, p["relative"] * stiffness * ca.sign(twist.angle) * extra)


def stiffness_error(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Stiffness off by a factor."""
    plant.scale(f"{place}.stiffness", 1 + p["relative"])


def damping_error(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Damping off by a factor."""
    plant.scale(f"{place}.damping", 1 + p["relative"])


def motor_inertia_error(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Inertia of a rotor off by a factor."""
    for motor in plant.motors(place):
        plant.armature[plant.place(motor)] += p["relative"] * plant.robot.motors[motor].inertia


def payload_error(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Mass and inertia of the last body off by a factor; a body of an added mode is not the load."""
    del place
    for name in ("mass", *(f"inertia.{entry}" for entry in INERTIA_COMPONENTS)):
        plant.scale(f"body_{plant.load_body}.{name}", 1 + p["relative"])


def gravity_error(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Weight of one body off by a factor, its inertia as it is."""
    name = f"body_{int(place.removeprefix('body_')) + plant.first_body}.mass"
    model = plant.robot.symbolic((name,))
    arm, mass = plant.q[: plant.robot.n_arm], ca.SX.sym("mass")
    zero = ca.SX.zeros(plant.robot.n_arm)
    weight = ca.jacobian(model.arm_inverse_dynamics(arm, zero, zero, mass), mass)
    weight = ca.substitute(weight, mass, ca.SX(model.parameter_values[0])) * model.parameter_values[0]
    for index in range(plant.robot.n_arm):
        plant.added[index] -= p["relative"] * weight[index]
