"""Candidates compiled together: each is predicted as alone, and where it is off, nothing of it is left."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.prediction.compiled_plant import LANES, CompiledPlant, compiled_plant, grouped, in_lanes, switchable
from flexros.gap.prediction.predictor import Predictor
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import MODEL, ROBOT, candidates_of, data_of

TOGETHER = ("coulomb_friction@motor_1", "viscous_friction@motor_1", "stiffness_error@body_1.rz")


def plant_of(*names: str) -> CompiledPlant:
    return CompiledPlant(MODEL, [candidates_of()[name] for name in names], (), ROBOT.sample_time)


@pytest.mark.parametrize("name", TOGETHER)
def test_a_candidate_is_predicted_as_with_a_plant_of_its_own(name: str) -> None:
    data, candidate = data_of(), candidates_of()[name]
    shared = Predictor(MODEL, (candidate,), Tolerance(), ROBOT.sample_time, plant=plant_of(*TOGETHER))
    own = Predictor(MODEL, (candidate,), Tolerance(), ROBOT.sample_time)
    theta = np.array(candidate.starts()[-1])[:, None]
    assert shared.plant is not own.plant
    np.testing.assert_allclose(data.residuals(shared, theta), data.residuals(own, theta), rtol=1e-6, atol=1e-6)


def test_a_plant_is_compiled_once_for_the_same_effects() -> None:
    every = candidates_of()
    one, other = (every[name] for name in TOGETHER[:2])
    model, step = MODEL, ROBOT.sample_time
    found = compiled_plant(model, (one, other), (), step)
    assert compiled_plant(model, (one, other), (), step) is found
    assert compiled_plant(model, (one, other), ("body_1.mass",), step) is not found
    assert compiled_plant(model, (one,), (), step) is not found


def test_a_plant_with_all_laws_off_is_the_nominal_one() -> None:
    data, nothing = data_of(), np.zeros((0, 1))
    shared = Predictor(MODEL, (), Tolerance(), ROBOT.sample_time, plant=plant_of(*TOGETHER))
    own = Predictor(MODEL, (), Tolerance(), ROBOT.sample_time)
    np.testing.assert_allclose(data.residuals(shared, nothing), data.residuals(own, nothing), atol=1e-6)


def test_a_plant_covers_what_it_holds_and_no_more() -> None:
    plant, every = plant_of(*TOGETHER), candidates_of()
    assert plant.covers(())
    assert plant.covers((every["coulomb_friction@motor_1"],))
    assert not plant.covers((every["torque_bias@motor_1"],))
    assert not plant.covers((every["motor_inertia_error@motor_1"],))


def test_a_lag_cannot_be_switched_off_and_has_a_plant_of_its_own() -> None:
    lag = candidates_of()["actuator_lag@motor_1"]
    assert not switchable(lag)
    assert [lag] in grouped(list(candidates_of().values()), 8)
    assert not plant_of("actuator_lag@motor_1").covers(())


def test_a_plant_with_fast_states_serves_no_hypothesis_without() -> None:
    plant, every = plant_of("presliding_friction@motor_1", "coulomb_friction@motor_1"), candidates_of()
    assert plant.covers((every["presliding_friction@motor_1"],))
    assert not plant.covers((every["coulomb_friction@motor_1"],))


@pytest.mark.parametrize(
    ("name", "steps"), [("torque_bias", 1), ("actuator_lag", 2), ("delay", 2), ("presliding_friction", 5)]
)
def test_a_lag_is_exact_in_long_steps_and_bristles_are_not(name: str, steps: int) -> None:
    """Steps of fast states made a diagnosis of six axes with a lag several times as long."""
    candidate = next(one for one in candidates_of().values() if one.effect.name == name)
    rigid = RobotWithEffects(load_robot("emps"), ())
    assert CompiledPlant(rigid, (candidate,), (), 0.004).steps.number == steps


def test_bristles_take_the_steps_of_delayed_torques_with_which_they_are_compared() -> None:
    every = candidates_of()
    presliding, delay = (every[name] for name in ("presliding_friction@motor_1", "delay@all"))
    plain, bent, late, rough = (
        CompiledPlant(MODEL, candidates, (), 5e-4, rough=rough).steps.number
        for candidates, rough in (
            ((), False),
            ((presliding,), False),
            ((presliding, delay), False),
            ((presliding,), True),
        )
    )
    assert (plain, bent, late, rough) == (1, 2, 2, 1)


def test_a_plant_with_a_delay_serves_no_hypothesis_without() -> None:
    plant, every = plant_of("delay@all", "coulomb_friction@motor_1"), candidates_of()
    assert plant.parts == 2
    assert plant.covers((every["delay@all"], every["coulomb_friction@motor_1"]))
    assert not plant.covers((every["coulomb_friction@motor_1"],))


def test_groups_hold_every_candidate_once_and_are_no_larger_than_allowed() -> None:
    candidates = list(candidates_of().values())
    groups = grouped(candidates, 3)
    assert sorted(one.name for group in groups for one in group) == sorted(one.name for one in candidates)
    assert max(len(group) for group in groups) == 3


def test_measured_torques_are_late_by_the_delay_of_a_patch_alone() -> None:
    """The delay of the robot file lies before them; that which a diagnosis found in them is part of the motion."""
    patched = MODEL.with_effects([parse_effect("delay@all:time=0.003", "test")])
    patched = patched.with_effects([parse_effect("coulomb_friction@motor_1:level=0.1", "test")])
    assert patched.robot.delay == pytest.approx(ROBOT.delay + 0.003)
    plants = {
        measured: CompiledPlant(patched, (), (), ROBOT.sample_time, measured_torque=measured)
        for measured in (False, True)
    }
    assert plants[True].delay == pytest.approx(0.003)
    assert plants[False].delay == pytest.approx(ROBOT.delay + 0.003)
    one = MODEL.with_effects([parse_effect("delay@motor_1:time=0.002", "test")])
    late = CompiledPlant(one, (), (), ROBOT.sample_time, measured_torque=True).delay
    assert np.ravel(late)[0] == pytest.approx(0.002)


def test_sets_of_numbers_are_divided_into_lanes_in_their_order() -> None:
    sets = np.arange(2.0 * (2 * LANES + 1)).reshape(2, -1)
    groups = in_lanes(sets)
    assert [group.shape[1] for group in groups] == [LANES, LANES, 1]
    np.testing.assert_array_equal(np.hstack(groups), sets)
