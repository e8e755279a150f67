"""Friction that sets in with time."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.compile.loop.arrays import LoopInputs
from flexros.compile.loop.kernel import compile_loop
from flexros.effects import parse_effect, place_effects
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant_model import PlantModel
from tests.effects.single_mass import MASS, SLIDE, T, plant, states


def test_coulomb_part_grows_to_its_level() -> None:
    path = states(plant("friction_drift@motor_1:coulomb=10,time_constant=0.2", start=(0.0, 0.5)), 500)
    time = 1e-3 * np.arange(501)
    momentum = MASS * 0.5 - 10.0 * (time - 0.2 * (1 - np.exp(-time / 0.2)))
    np.testing.assert_allclose(MASS * path[:, 1], momentum, rtol=1e-5)


def test_viscous_part_grows_to_its_coefficient() -> None:
    path = states(plant("friction_drift@motor_1:viscous=50,time_constant=0.2", start=(0.0, 0.5)), 500)
    time = 1e-3 * np.arange(501)
    expected = 0.5 * np.exp(-50.0 / MASS * (time - 0.2 * (1 - np.exp(-time / 0.2))))
    np.testing.assert_allclose(path[:, 1], expected, rtol=1e-9)


def test_negative_change_eases_the_coulomb_friction_down_to_none() -> None:
    effects = ("coulomb_friction@motor_1:level=10", "friction_drift@motor_1:coulomb=-40,time_constant=0.1")
    path = states(plant(*effects, start=(0.0, 0.5)), 400)
    speed = path[:, 1]
    free = 0.1 * np.log(40 / 30)  # when the sum has fallen to zero
    assert np.all(np.diff(speed[: int(free * 1000)]) < 0)
    assert np.ptp(speed[int(free * 1000) + 2 :]) < 1e-12
    impulse = 10 * free - 40 * (free - 0.1 * (1 - np.exp(-free / 0.1)))
    assert MASS * (0.5 - speed[-1]) == pytest.approx(impulse, rel=1e-3)


def test_drift_goes_on_where_a_run_is_taken_up_later() -> None:
    effect = parse_effect("friction_drift@motor_1:coulomb=10,viscous=20,time_constant=0.2", "test")
    model = PlantModel(SLIDE, place_effects(SLIDE, [effect]).laws)
    kernel = compile_loop(model.functions(feed_through(1)), sample_time=T)
    rest = LoopInputs(reference=np.zeros((1, 3)), gains=np.zeros(0))
    whole = kernel.run(kernel.initial_state(model.start(np.array([0.0, 0.5]))), 200, rest, record_states=True)
    assert whole.states is not None
    later = kernel.initial_state(model.start(whole.states[120, :2], time=120 * T))
    np.testing.assert_allclose(kernel.run(later, 80, rest).encoder, whole.encoder[120:], atol=1e-13)


def test_substeps_converge_with_order_two() -> None:
    def path(substeps: int) -> np.ndarray:
        effect = "friction_drift@motor_1:coulomb=40,viscous=20,time_constant=0.05"
        return states(plant(effect, start=(0.0, 0.6), substeps=substeps, sample_time=0.01), 30)[:, 1]

    exact = path(128)
    errors = [np.max(np.abs(path(substeps) - exact)) for substeps in (1, 2, 4)]
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 1.8)
