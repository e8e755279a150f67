"""Equations of the axis against those of the robot's model, and laws of its friction."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.identify.axis import AxisStructure
from flexros.robot import Robot, load_robot
from tests.identify.axis.recorded_axis import TRUTH, three_mass

VALUES = {**TRUTH, "viscous_friction": 0.0, "coulomb_friction": 0.0, "gear_stiffening": 1.0}
THREE = VALUES | {"arm_1_inertia": 4.0, "arm_2_inertia": 2.0, "arm_stiffness": 5e4, "arm_damping": 20.0}


def rate(structure: AxisStructure, x: list[float], torque: float, values: dict[str, float]) -> np.ndarray:  # type: ignore[type-arg]
    theta = [values[name] for name in structure.names]
    return structure.derivative(0.01)(x, torque, theta).full().ravel()


@pytest.mark.parametrize(
    ("robot", "masses", "values"), [(load_robot("two_mass"), 2, VALUES), (three_mass(), 3, THREE)], ids=["2", "3"]
)
def test_equations_are_those_of_the_robot(robot: Robot, masses: int, values: dict[str, float]) -> None:
    rng = np.random.default_rng(1)
    q, v = 1e-3 * rng.standard_normal(masses), rng.standard_normal(masses)
    x = np.concatenate([q, v])
    if masses == 3:  # the robot counts its last arm coordinate from the one before
        q, v = (np.array([w[0], w[0] + w[1], w[2]]) for w in (q, v))
    order = [masses - 1, *range(masses - 1)]  # motor first
    accelerations = robot.model.derivative(x, 7.0, np.zeros(6), ca.DM(0, 1)).full().ravel()[masses:]
    if masses == 3:
        accelerations = np.array([accelerations[0], accelerations[0] + accelerations[1], accelerations[2]])
    structure = AxisStructure(masses=masses)  # type: ignore[arg-type]
    chain = q[order]
    state = [chain[0], *(chain[:-1] - chain[1:]), *v[order]]
    result = rate(structure, state, 7.0, values)
    np.testing.assert_allclose(result[masses:], accelerations[order], rtol=1e-9)
    np.testing.assert_allclose(result[:masses], [v[order][0], *(v[order][:-1] - v[order][1:])], rtol=1e-12)


def test_without_the_position_the_rest_stays_the_same() -> None:
    x = [0.3, 0.002, 0.5, -0.2]
    full = rate(AxisStructure(), x, 3.0, VALUES)
    np.testing.assert_array_equal(rate(AxisStructure(output="velocity"), x[1:], 3.0, VALUES), full[1:])


@pytest.mark.parametrize(("speed", "level"), [(10.0, 5.0), (0.1, 5.0 + 3.0 * np.exp(-0.25)), (-10.0, -5.0)])
def test_friction_is_viscous_plus_coulomb_plus_hump(speed: float, level: float) -> None:
    structure = AxisStructure(stribeck=True, offset=True)
    friction = {"viscous_friction": 2.0, "coulomb_friction": 5.0, "stribeck_friction": 3.0, "stribeck_speed": 0.2}
    values = VALUES | friction | {"offset": 1.5}
    acceleration = rate(structure, [0.0, 0.0, speed, speed], 0.0, values)[2]
    assert -4.0 * acceleration == pytest.approx(2.0 * speed + level - 1.5, rel=1e-6)


def test_every_parameter_has_a_unit_for_turning_and_sliding() -> None:
    for gear in ("linear", "piecewise", "cubic"):
        turning, sliding = (
            AxisStructure(masses=3, gear=gear, stribeck=True, offset=True, rotary=rotary)  # type: ignore[arg-type]
            for rotary in (True, False)
        )
        assert turning.names == sliding.names
        assert all("rad" not in unit for unit in sliding.units.values())
    assert AxisStructure().units["gear_knee"] == "rad"
    assert AxisStructure(rotary=False).units["motor_inertia"] == "kg"
