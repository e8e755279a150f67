"""Model sets of the benchmark: the nominal model and two sets of ten perturbed ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import unknown_name
from flexros.robot import load_robot
from flexros.robot.robot import robot_from_data

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot

ROBOT = "four_mass"
"""Robot of the benchmark."""

SENSORS = {
    "tool_acceleration": {
        "tool_imu": {"acceleration": {"noise": {"value": 0.02, "unit": "m/s2", "source": "chosen"}, "axes": ["x"]}}
    }
}
"""Sensors that a design may use beside the motor encoder, as keys of the robot file; their noise is chosen."""

GROUPS: tuple[tuple[str, ...], ...] = (
    ("body_1.rz.stiffness",),
    ("body_2.rz.stiffness",),
    ("body_3.rz.stiffness",),
    ("body_1.inertia.zz",),
    ("body_2.inertia.zz",),
    ("body_3.inertia.zz",),
    ("body_1.rz.damping", "body_2.rz.damping", "body_3.rz.damping"),
    (
        "motor_1.viscous_friction",
        "body_1.viscous_friction",
        "body_2.viscous_friction",
        "body_3.viscous_friction",
    ),
)
"""Parameters that change by one factor: k1 (the whole spring law), k2, k3, Ja1, Ja2, Ja3, dampers, friction."""

PARAMETERS = tuple(name for group in GROUPS for name in group)
"""Parameters that differ between the models."""

SIGNS = (
    "++-+++--",
    "-++-+++-",
    "+-++-+++",
    "-+-++-++",
    "--+-++-+",
    "---+-++-",
    "+---+-++",
    "++---+-+",
    "+++---+-",
    "--------",
)
"""Signs of the deviations of `GROUPS` in the models 1 to 10 of a set (chosen)."""


@dataclass(frozen=True)
class SetRules:
    """Deviations, weight and demands of a model set.

    Attributes:
        stiffness: Relative deviation of the stiffness [1], chosen.
        inertia: Relative deviation of the inertia [1], chosen.
        losses: Relative deviation of dampers and friction [1], chosen.
        weight: Weight of the set in the cost V [1], inferred from Tables 1 and 2 of Paper C.
        band: Band of the settling time [mm], Paper C, section 5.4.
        deadline: Largest settling time [s], Paper C, section 5.5.
    """

    stiffness: float
    inertia: float
    losses: float
    weight: float
    band: float
    deadline: float


RULES = {
    "nominal": SetRules(0.0, 0.0, 0.0, weight=0.6, band=0.1, deadline=3.0),
    "M1": SetRules(0.15, 0.10, 0.30, weight=1.0, band=0.1, deadline=3.0),
    "M2": SetRules(0.30, 0.20, 0.50, weight=0.3, band=0.3, deadline=4.0),
}
"""The model sets by name."""

NOMINAL = "nominal"
"""Set of the nominal model, which the first controller regulates; the second one regulates the other sets."""


def benchmark_robot(sensors: Sequence[str] = ()) -> Robot:
    """Return the robot of the benchmark.

    Args:
        sensors: Names of sensors beside the motor encoder, keys of `SENSORS`.

    Raises:
        InputError: Unknown sensor.
    """
    if not sensors:
        return load_robot(ROBOT)
    data = load_robot(ROBOT).spec.model_dump()
    for name in sensors:
        if name not in SENSORS:
            raise unknown_name("sensor of the benchmark", name, SENSORS)
        data["sensors"].update(SENSORS[name])
    return robot_from_data(data, f"{ROBOT} with {', '.join(sensors)}")


def set_values(robot: Robot, name: str) -> FloatArray:
    """Return the parameters of the models of a set.

    Args:
        robot: The robot of the benchmark.
        name: Name of the set, a key of `RULES`.

    Returns:
        Values of `PARAMETERS` (SI), shape (1 or 10, n_parameters).
    """
    nominal = np.array([robot.parameters[parameter].value for parameter in PARAMETERS])
    if name == NOMINAL:
        return nominal[None, :]
    rules = RULES[name]
    deviation = np.array([*(rules.stiffness,) * 3, *(rules.inertia,) * 3, rules.losses, rules.losses])
    signs = np.array([[1.0 if sign == "+" else -1.0 for sign in row] for row in SIGNS])
    repeats = [len(group) for group in GROUPS]
    return np.asarray(nominal * np.repeat(1.0 + signs * deviation, repeats, axis=1))


def model_names(name: str) -> tuple[str, ...]:
    """Return the names of the models of a set, e.g. "M1 model 3"."""
    return (name,) if name == NOMINAL else tuple(f"{name} model {number}" for number in range(1, len(SIGNS) + 1))
