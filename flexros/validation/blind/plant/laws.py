"""All deviations of the blind check by name: those of the effects library in another formulation, and others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import casadi as ca

from flexros.validation.blind.plant import drive, friction, gear
from flexros.validation.blind.plant import outside_causes as outside
from flexros.validation.blind.plant.equations import Equations

Law: TypeAlias = Callable[[Equations, str, Mapping[str, ca.SX]], None]
"""Adds a deviation at a location, with symbolic parameters, to the equations of a plant."""


def no_equation(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Change nothing here: the robot was given another body before, or its tool is seen wrongly."""
    del plant, place, p


LIBRARY_LAWS: Mapping[str, Law] = {
    "viscous_friction": friction.viscous,
    "coulomb_friction": friction.coulomb,
    "stribeck_friction": friction.stribeck,
    "presliding_friction": friction.presliding,
    "friction_drift": friction.drift,
    "backlash": gear.backlash,
    "hysteresis": gear.hysteresis,
    "nonlinear_stiffness": gear.nonlinear_stiffness,
    "transmission_error": gear.transmission_error,
    "stiffness_error": gear.stiffness_error,
    "damping_error": gear.damping_error,
    "payload_error": gear.payload_error,
    "motor_inertia_error": gear.motor_inertia_error,
    "torque_gain_error": drive.gain,
    "torque_bias": drive.bias,
    "torque_ripple": drive.ripple,
    "torque_saturation": drive.saturation,
    "actuator_lag": drive.lag,
    "delay": drive.delay,
    "encoder_quantization": drive.quantization,
    "encoder_eccentricity": drive.eccentricity,
    "extra_mode": no_equation,
    "gravity_error": gear.gravity_error,
    "kinematic_error": no_equation,
    "load_dependent_friction": friction.loaded,
}
"""Deviations with the names of the effects library (contract of section 8)."""

OUTSIDE_LAWS: Mapping[str, Law] = {
    "position_dependent_friction": outside.position_dependent_friction,
    "quadratic_drag": outside.quadratic_drag,
    "tool_pushes": outside.tool_pushes,
    "rotating_imbalance": outside.rotating_imbalance,
    "cable": outside.cable,
    "varying_stiffness": outside.varying_stiffness,
    "periodic_disturbance": outside.periodic_disturbance,
    "lost_commands": outside.lost_commands,
}
"""Causes outside the effects library."""

LAWS: Mapping[str, Law] = {**LIBRARY_LAWS, **OUTSIDE_LAWS}
"""Both together."""
