"""Functions of a plant in stages equal those that are written out."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.compile.nested_calls import nested_calls
from flexros.compile.sx_emitter import PART_LENGTH
from flexros.effects import parse_effect, place_effects
from flexros.robot import Robot, load_robot
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant_model import PlantModel
from flexros.simulate.stages import Stages
from tests.ur5e import ur5e

FRICTION = (
    "coulomb_friction@motor_2:level=5",
    "viscous_friction@motor_3:coefficient=2",
    "coulomb_friction@motor_5:level=1",
)


def plant(robot: Robot, *effects: str) -> PlantModel:
    return PlantModel(robot, place_effects(robot, [parse_effect(text, "test") for text in effects]).laws)


def values(function: ca.Function, seed: int = 0) -> list[np.ndarray]:
    """Random inputs; the last one of an update is the length of a step."""
    rng = np.random.default_rng(seed)
    return [rng.normal(scale=0.3, size=function.size_in(k)) for k in range(4)] + [1e-3] * (function.n_in() - 4)


def test_short_functions_are_written_out() -> None:
    x = ca.SX.sym("x", 2)
    stages = Stages([x])
    value = stages.call(ca.Function("square", [x], [x**2]), 3 * x)[0]
    function = stages.function("whole", value + x)
    assert function.is_a("SXFunction")
    np.testing.assert_array_equal(np.ravel(function([1.0, 2.0]).full()), [10.0, 38.0])


def test_a_call_may_need_what_another_returns() -> None:
    """Three long functions of which the last takes the results of the others, as the stages of an implicit step do."""
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    value = x
    for k in range(PART_LENGTH):
        value = ca.sin(value) + k * y
    long = ca.Function("long", [x, y], [value])
    stages = Stages([x, y])
    first, second = stages.call(long, x, y)[0], stages.call(long, y, x)[0]
    function = stages.function("whole", x + stages.call(long, first + x, second)[0] - first)
    assert nested_calls(function) is not None
    a, b = long(0.3, 0.01), long(0.01, 0.3)
    assert float(function(0.3, 0.01)) == pytest.approx(float(0.3 + long(a + 0.3, b) - a), rel=1e-12)


@pytest.mark.parametrize("effects", [FRICTION[:1], FRICTION])
def test_long_dynamics_are_called(effects: tuple[str, ...]) -> None:
    model = plant(ur5e(), *effects)
    functions = model.functions(feed_through(6))
    before = functions.before_step
    assert functions.after_step is None
    assert before is not None
    for function in (model.derivative, before):
        assert nested_calls(function) is not None
        given = values(function)
        np.testing.assert_allclose(function(*given).full(), function.expand()(*given).full(), rtol=1e-13, atol=1e-13)


def test_accelerations_with_friction_obey_the_dynamics() -> None:
    """The derivative of the staged plant is the acceleration of the robot under torques less friction."""
    robot = ur5e()
    model = plant(robot, *FRICTION[:1])
    x, u, w, p = values(model.derivative)
    n = robot.n_coordinates
    rates = model.derivative(x, u, w, p).full().ravel()
    torque = u.copy()
    torque[1] -= x[2 * n]
    expected = robot.model.acceleration(x[:n], x[n : 2 * n], torque, w, p).full().ravel()
    np.testing.assert_allclose(rates[n : 2 * n], expected, rtol=1e-12)


def test_short_robots_have_no_stages() -> None:
    model = plant(load_robot("elbow"), "coulomb_friction@motor_1:level=1")
    assert model.derivative.is_a("SXFunction")
