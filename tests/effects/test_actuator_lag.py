"""The torque of a motor follows its command by a first-order lag."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.robot import load_robot
from tests.effects.single_mass import MASS, T, plant, states


@pytest.mark.parametrize("constant", [1e-6, 3e-4, 1e-3, 0.02, 0.9])
def test_step_response_is_that_of_the_exact_lag_at_all_samples(constant: float) -> None:
    path = states(plant(f"actuator_lag@motor_1:time_constant={constant}"), 50, lambda time: 10.0)
    time = T * np.arange(51)
    momentum = 10.0 * (time - constant * (1 - np.exp(-time / constant)))
    np.testing.assert_allclose(MASS * path[:, 1], momentum, rtol=1e-9, atol=1e-12)


def test_time_constant_far_below_the_step_is_no_stiffness_and_no_lag() -> None:
    def force(time: float) -> float:
        return 30.0 * np.sin(200 * time)

    lagging, prompt = (
        states(plant(f"actuator_lag@motor_1:time_constant={constant}"), 200, force) for constant in (1e-9, 0.0)
    )
    np.testing.assert_allclose(lagging, prompt, atol=1e-8)


def test_substeps_converge_with_order_four() -> None:
    robot = load_robot("two_mass")

    def path(substeps: int) -> FloatArray:
        moving = plant("actuator_lag@motor_1:time_constant=0.003", start=(0, 0, 0, 0), robot=robot, substeps=substeps)
        return states(moving, 200, lambda time: 300.0 if time < 0.1 else -200.0)

    exact = path(64)
    errors = [np.max(np.abs(path(substeps) - exact)) for substeps in (1, 2, 4)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.8)
    assert errors[0] < 1e-4 * np.max(np.abs(exact))
