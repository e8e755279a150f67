"""Shapes and sizes of deviations at gears, springs, bodies, tool and base, and of causes outside the library."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np

from flexros.validation.blind.draw.draw import Drawer, Numbers, Site, log_uniform, sign

Drawn: TypeAlias = tuple[Callable[[float], Numbers], float]


def _backlash(at: Site, random: np.random.Generator) -> Drawn:
    del random
    return lambda s: {"gap": 1e-2 * at.deflection * s}, 100.0


def _hysteresis(at: Site, random: np.random.Generator) -> Drawn:
    angle = at.deflection * log_uniform(random, 0.02, 0.3)
    return lambda s: {"level": 1e-3 * at.torque * s, "angle": angle}, 200.0


def _nonlinear(at: Site, random: np.random.Generator) -> Drawn:
    knee, direction = at.deflection * float(random.uniform(0.2, 0.6)), float(random.choice([1.0, 1.0, -1.0]))
    return lambda s: {"relative": 0.01 * direction * s, "knee": knee}, 150.0 if direction > 0 else 60.0


def _transmission(at: Site, random: np.random.Generator) -> Drawn:
    order, phase = at.order(random), float(random.uniform(-np.pi, np.pi))
    return lambda s: {"amplitude": 1e-3 * at.deflection * s, "order": order, "phase": phase}, 500.0


def _relative(unit: float, up: float, down: float) -> Drawer:
    def drawn(at: Site, random: np.random.Generator) -> Drawn:
        del at
        direction = sign(random)
        return lambda s: {"relative": unit * direction * s}, (up if direction > 0 else down) / unit

    return drawn


def _payload(at: Site, random: np.random.Generator) -> Drawn:
    del at
    direction = sign(random)
    return lambda s: {"relative": 1e-3 * direction * s}, 500.0


def _mode(at: Site, random: np.random.Generator) -> Drawn:
    damping = float(random.uniform(0.01, 0.05))
    if at.location == "tool":
        robot, frequency = at.scales.robot, log_uniform(random, 8.0, 50.0)
        heavy = robot.spec.bodies[-1].mass.value > 0 and not np.any(robot.spec.gravity.value)
        point = float(heavy and random.uniform() < 0.5)
        return lambda s: {"frequency": frequency, "ratio": 1e-3 * s, "damping": damping, "point": point}, 300.0
    ratio = float(random.uniform(0.5, 3.0))
    return lambda s: {"frequency": 1000.0 / np.sqrt(s), "ratio": ratio, "damping": damping}, 1e4


def _kinematic(at: Site, random: np.random.Generator) -> Drawn:
    del at
    direction = sign(random)
    return lambda s: {"length": 1e-6 * direction * s}, 3e4


def _loaded(at: Site, random: np.random.Generator) -> Drawn:
    del random
    least = 5e-3 * at.torque
    return lambda s: {"share": 1e-3 * s, "least": least}, 300.0


STRUCTURE_DRAWERS: Mapping[str, Drawer] = {
    "backlash": _backlash,
    "hysteresis": _hysteresis,
    "nonlinear_stiffness": _nonlinear,
    "transmission_error": _transmission,
    "stiffness_error": _relative(1e-3, 0.6, 0.5),
    "damping_error": _relative(1e-2, 2.0, 0.8),
    "payload_error": _payload,
    "extra_mode": _mode,
    "gravity_error": _relative(1e-4, 0.4, 0.4),
    "kinematic_error": _kinematic,
    "load_dependent_friction": _loaded,
}
"""Drawing functions of deviations at gears and structure, by name."""


def _rough_way(at: Site, random: np.random.Generator) -> Drawn:
    length = float(at.scales.way[at.motor]) * float(random.uniform(0.15, 0.5))
    phase = float(random.uniform(-np.pi, np.pi))
    return lambda s: {"level": 1e-3 * at.torque * s, "length": length, "phase": phase}, 200.0


def _churning(at: Site, random: np.random.Generator) -> Drawn:
    del random
    return lambda s: {"coefficient": 1e-3 * at.torque / at.speed**2 * s}, 300.0


def _pushes(at: Site, random: np.random.Generator) -> Drawn:
    del random
    return lambda s: {"height": 1e-3 * at.torque * s}, 500.0


def _imbalance(at: Site, random: np.random.Generator) -> Drawn:
    speed, run_up = log_uniform(random, 4.0, 25.0), float(random.uniform(0.2, 1.0))
    return lambda s: {"force": 1e-3 * at.torque * s, "speed": speed, "run_up": run_up}, 300.0


def _cable(at: Site, random: np.random.Generator) -> Drawn:
    way = float(at.scales.way[at.motor])
    angle = float(at.scales.middle[at.motor]) + way * float(random.uniform(0.1, 0.3))
    return lambda s: {"torque": 1e-3 * at.torque * s, "angle": angle, "length": 0.1 * way}, 300.0


def _swing(at: Site, random: np.random.Generator) -> Drawn:
    frequency, phase = log_uniform(random, 0.1, 0.5), float(random.uniform(-np.pi, np.pi))
    return lambda s: {"relative": 1e-3 * s, "frequency": frequency, "phase": phase}, 400.0


def _hum(at: Site, random: np.random.Generator) -> Drawn:
    frequency, phase = log_uniform(random, 3.0, 40.0), float(random.uniform(-np.pi, np.pi))
    return lambda s: {"amplitude": 1e-3 * at.torque * s, "frequency": frequency, "phase": phase}, 200.0


def _losses(at: Site, random: np.random.Generator) -> Drawn:
    del at, random
    return lambda s: {"share": 1e-4 * s}, 1e3


OUTSIDE_DRAWERS: Mapping[str, Drawer] = {
    "position_dependent_friction": _rough_way,
    "quadratic_drag": _churning,
    "tool_pushes": _pushes,
    "rotating_imbalance": _imbalance,
    "cable": _cable,
    "varying_stiffness": _swing,
    "periodic_disturbance": _hum,
    "lost_commands": _losses,
}
"""Drawing functions of causes outside the library, by name."""
