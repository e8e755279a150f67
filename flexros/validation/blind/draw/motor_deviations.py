"""Shapes and sizes of deviations at motors and encoders (magnitudes of the field, see each)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np

from flexros.validation.blind.draw.draw import Drawer, Numbers, Site, log_uniform, sign

Drawn: TypeAlias = tuple[Callable[[float], Numbers], float]

RESOLUTION = 6.0
"""Step of an encoder over its noise, rms, up to which it is a property of the sensor and nothing is hidden [1]."""


def _asymmetry(random: np.random.Generator) -> float:
    return float(random.uniform(-0.6, 0.6)) if random.uniform() < 0.5 else 0.0


def _viscous(at: Site, random: np.random.Generator) -> Drawn:
    unit, asymmetry = 1e-3 * at.torque / at.speed, _asymmetry(random)
    return lambda s: {"coefficient": s * unit, "asymmetry": asymmetry}, 300.0


def _coulomb(at: Site, random: np.random.Generator) -> Drawn:
    unit, asymmetry = 1e-3 * at.torque, _asymmetry(random)
    return lambda s: {"level": s * unit, "asymmetry": asymmetry}, 200.0


def _stribeck(at: Site, random: np.random.Generator) -> Drawn:
    unit, velocity = 3e-3 * at.torque, at.speed * log_uniform(random, 3e-3, 5e-2)
    return lambda s: {"extra": s * unit, "velocity": velocity}, 50.0


def _presliding(at: Site, random: np.random.Generator) -> Drawn:
    unit, extra = 1e-3 * at.torque, float(random.uniform(0.2, 0.6))
    velocity = at.speed * log_uniform(random, 3e-3, 3e-2)
    bend, damping = at.noise * log_uniform(random, 10, 200), float(random.uniform(0.3, 1.0))
    inertia = at.scales.robot.motors[at.motor].inertia

    def shape(s: float) -> Numbers:
        stiffness = s * unit / bend
        return {
            "level": s * unit,
            "extra": s * unit * extra,
            "velocity": velocity,
            "stiffness": stiffness,
            "damping": damping * np.sqrt(stiffness * inertia),
        }

    return shape, 200.0


def _drift(at: Site, random: np.random.Generator) -> Drawn:
    unit, share = 2e-3 * at.torque, float(random.uniform(0.2, 0.8))
    time, duration = at.scales.duration * float(random.uniform(0.2, 1.0)), at.scales.duration
    return lambda s: {
        "coulomb": s * unit * share,
        "viscous": s * unit * (1 - share) / at.speed,
        "time_constant": time,
        "duration": duration,
    }, 100.0


def _gain(at: Site, random: np.random.Generator) -> Drawn:
    unit = 1e-3 * sign(random)
    return lambda s: {"relative": s * unit}, 300.0


def _inertia(at: Site, random: np.random.Generator) -> Drawn:
    unit = 1e-3 * sign(random)
    return lambda s: {"relative": s * unit}, 500.0


def _bias(at: Site, random: np.random.Generator) -> Drawn:
    unit = 1e-3 * at.torque * sign(random)
    return lambda s: {"level": s * unit}, 200.0


def _ripple(at: Site, random: np.random.Generator) -> Drawn:
    proportional = float(random.uniform() < 0.3)
    unit = 1e-3 if proportional else 1e-3 * at.torque
    order, phase = at.order(random), float(random.uniform(-np.pi, np.pi))
    return lambda s: {"amplitude": s * unit, "order": order, "phase": phase, "proportional": proportional}, 100.0


def _saturation(at: Site, random: np.random.Generator) -> Drawn:
    del random
    return lambda s: {"limit": at.torque * (1 - 0.02 * s)}, 35.0


def _lag(at: Site, random: np.random.Generator) -> Drawn:
    del at, random
    return lambda s: {"time_constant": 1e-5 * s}, 300.0


def _delay(at: Site, random: np.random.Generator) -> Drawn:
    del at, random
    return lambda s: {"time": 1e-5 * s}, 500.0


def _quantization(at: Site, random: np.random.Generator) -> Drawn:
    least = RESOLUTION * log_uniform(random, 1.2, 8.0)
    return lambda s: {"step": at.noise * (least + s)}, 300.0


def _eccentricity(at: Site, random: np.random.Generator) -> Drawn:
    order, phase = at.order(random), float(random.uniform(-np.pi, np.pi))
    return lambda s: {"amplitude": 0.1 * at.noise * s, "order": order, "phase": phase}, 3e3


MOTOR_DRAWERS: Mapping[str, Drawer] = {
    "viscous_friction": _viscous,
    "coulomb_friction": _coulomb,
    "stribeck_friction": _stribeck,
    "presliding_friction": _presliding,
    "friction_drift": _drift,
    "motor_inertia_error": _inertia,
    "torque_gain_error": _gain,
    "torque_bias": _bias,
    "torque_ripple": _ripple,
    "torque_saturation": _saturation,
    "actuator_lag": _lag,
    "delay": _delay,
    "encoder_quantization": _quantization,
    "encoder_eccentricity": _eccentricity,
}
"""Drawing functions of deviations at motors, by name."""
