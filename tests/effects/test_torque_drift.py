"""Torque of unknown law: a curve over the time."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.compile.loop.arrays import LoopInputs
from flexros.compile.loop.kernel import compile_loop
from flexros.effects import parse_effect, place_effects
from flexros.effects.torque_drift import TorqueDrift
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant_model import PlantModel
from tests.effects.single_mass import MASS, SLIDE, T, plant, states

CURVE = "torque_drift@motor_1:torque_1=4,torque_2=-6,torque_4=10,torque_6=5,begin=0.05,end=0.3"
KNOTS, TORQUES = 0.05 * np.arange(1, 7), np.array([4.0, -6.0, 0.0, 10.0, 0.0, 5.0])


def test_torque_is_interpolated_between_knots_and_constant_before_and_after() -> None:
    path = states(plant(CURVE), 500)
    middle = 1e-3 * (np.arange(500) + 0.5)  # exact: the knots are at samples
    np.testing.assert_allclose(MASS * np.diff(path[:, 1]) / 1e-3, np.interp(middle, KNOTS, TORQUES), rtol=1e-6)


def test_it_acts_alike_in_both_directions() -> None:
    forward, backward = (states(plant(CURVE, start=(0.0, speed)), 300)[:, 1] - speed for speed in (0.5, -0.5))
    np.testing.assert_allclose(forward, backward, atol=1e-12)


def test_drift_goes_on_where_a_run_is_taken_up_later() -> None:
    model = PlantModel(SLIDE, place_effects(SLIDE, [parse_effect(CURVE, "test")]).laws)
    kernel = compile_loop(model.functions(feed_through(1)), sample_time=T)
    rest = LoopInputs(reference=np.zeros((1, 3)), gains=np.zeros(0))
    whole = kernel.run(kernel.initial_state(model.start(np.array([0.0, 0.5]))), 300, rest, record_states=True)
    assert whole.states is not None
    later = kernel.initial_state(model.start(whole.states[170, :2], time=170 * T))
    np.testing.assert_allclose(kernel.run(later, 130, rest).encoder, whole.encoder[170:], atol=1e-13)


def test_substeps_converge_with_order_two() -> None:
    """Corners between two samples cost no order."""

    def path(substeps: int) -> np.ndarray:
        effect = "torque_drift@motor_1:torque_2=40,torque_3=-30,torque_5=20,torque_6=10,begin=0.007,end=0.291"
        friction = "viscous_friction@motor_1:coefficient=200"
        return states(plant(effect, friction, substeps=substeps, sample_time=0.01), 30)[:, 1]

    exact = path(512)
    errors = [np.max(np.abs(path(substeps) - exact)) for substeps in (1, 16)]
    assert np.log2(errors[0] / errors[1]) > 4 * 1.8


@pytest.mark.parametrize("name", TorqueDrift.ranges)
def test_curve_without_sizes_is_switched_off(name: str) -> None:
    assert TorqueDrift(begin=3.0, end=7.0).neutral
    assert not TorqueDrift(**{name: 0.1}).neutral
