"""Friction with a hump at low speed: levels, slowing down, sticking."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexros.arrays import FloatArray
from flexros.effects.friction.stribeck_friction import StribeckFriction
from flexros.effects.kinds.motor_law import MotorState
from tests.effects.single_mass import MASS, plant, states

HUMP = "stribeck_friction@motor_1:extra=40,velocity=0.1"


@pytest.mark.parametrize("speed", [0.0, 0.05, -0.05, 0.1, -1.0])
def test_level_is_the_hump_alone(speed: float) -> None:
    effect = StribeckFriction(extra=40.0, velocity=0.1)
    levels = effect.levels(MotorState(ca.SX(0), ca.SX(0), ca.SX(speed), ca.SX(0)), effect.parameter_values)
    expected = 40.0 * np.exp(-((speed / 0.1) ** 2))
    assert [float(ca.DM(level)) for level in (levels.forward, levels.backward)] == pytest.approx([expected] * 2)


def test_slowing_down_follows_the_hump_and_ends_at_rest() -> None:
    path = states(plant(HUMP, "coulomb_friction@motor_1:level=30", start=(0.0, 0.4)), 3000)

    def slope(time: float, speed: FloatArray) -> FloatArray:
        return -(30.0 + 40.0 * np.exp(-((speed / 0.1) ** 2))) / MASS

    exact = solve_ivp(slope, (0.0, 3.0), [0.4], rtol=1e-11, atol=1e-12, t_eval=1e-3 * np.arange(3001)).y[0]
    moving = exact > 0.01
    assert 500 < np.count_nonzero(moving) < 3000
    np.testing.assert_allclose(path[moving, 1], exact[moving], atol=2e-6)
    assert abs(path[-1, 1]) < 1e-18


def test_standstill_holds_up_to_the_sum_of_the_levels() -> None:
    held, slipping = (states(plant(HUMP), 500, lambda time, push=push: push) for push in (39.9, 40.1))
    assert np.max(np.abs(held[:, 0])) < 1e-15
    assert slipping[-1, 0] > 1e-4


def test_energy_only_falls() -> None:
    path = states(plant(HUMP, start=(0.0, 0.15)), 2000)
    assert np.max(np.diff(path[:, 1] ** 2)) <= 0.0


def test_substeps_converge_with_order_two_while_it_slides() -> None:
    def path(substeps: int) -> FloatArray:
        moving = plant(HUMP, start=(0.0, 0.4), substeps=substeps, sample_time=0.01)
        return states(moving, 60, lambda time: 60.0 * np.sin(8 * time))[:, 1]

    exact = path(128)
    assert np.min(exact) > 0.02
    errors = [np.max(np.abs(path(substeps) - exact)) for substeps in (1, 2, 4)]
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 1.8)


def test_the_exponent_shapes_the_hump() -> None:
    effect = StribeckFriction(extra=40.0, velocity=0.1, exponent=0.8)
    for speed in (0.0, 0.02, -0.3):
        level = effect.levels(MotorState(ca.SX(0), ca.SX(0), ca.SX(speed), ca.SX(0)), effect.parameter_values).forward
        assert float(ca.DM(level)) == pytest.approx(40.0 * np.exp(-(abs(speed / 0.1) ** 0.8)))


def test_a_hump_with_a_stiffness_holds_by_bristles() -> None:
    numbers = "extra=40,velocity=0.1,stiffness=1e7,damping=2e3"
    path, bristles, rigid = (
        states(plant(effect, start=(0.0, 0.3)), 600)
        for effect in (f"stribeck_friction@motor_1:{numbers}", f"presliding_friction@motor_1:{numbers}", HUMP)
    )
    assert np.array_equal(path[:, :2], bristles[:, :2])
    assert 0 < np.max(np.abs(path[:, 1] - rigid[:, 1])) < 1e-3 * np.max(rigid[:, 1])
