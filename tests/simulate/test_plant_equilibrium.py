"""States of rest of plants whose springs have laws: those of the robot that the same law makes of the robot file."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.robot import load_robot
from flexros.scenario.batch import batch, whole_record
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario
from flexros.simulate.plant_model import PlantModel

ROBOT = load_robot("elbow")
BENT = "nonlinear_stiffness@body_2.ry:relative=-0.6,knee=3e-4"


def test_rest_with_a_law_of_a_spring_is_that_of_the_changed_robot() -> None:
    placed = [parse_effect(BENT, "test")]
    law, changed = place_effects(ROBOT, placed, as_laws=True), place_effects(ROBOT, placed)
    assert law.laws
    assert not changed.laws
    start = ROBOT.equilibrium()
    rest = PlantModel(law.robot, law.laws).rest(start)
    other = changed.robot.equilibrium_with_motors_held.find(start[: ROBOT.n_coordinates], np.zeros(0))
    np.testing.assert_allclose(rest.state, other.state, atol=1e-12)
    np.testing.assert_allclose(rest.torque, other.torque, rtol=1e-9)
    assert np.max(np.abs(rest.state - start)) > 1e-4


def test_rest_follows_the_free_parameters_of_robot_and_law() -> None:
    law = place_effects(ROBOT, [parse_effect(BENT, "test")], as_laws=True)
    names = ["nonlinear_stiffness@body_2.ry.relative", "body_2.mass"]
    model = PlantModel(law.robot, law.laws, names)
    start = ROBOT.equilibrium()
    for relative, mass in ((-0.6, 45.0), (0.0, 45.0), (-0.3, 60.0)):
        robot = place_effects(
            ROBOT.with_values({"body_2.mass": mass}),
            [parse_effect(f"nonlinear_stiffness@body_2.ry:relative={relative},knee=3e-4", "test")],
        ).robot
        expected = robot.equilibrium_with_motors_held.find(start[: ROBOT.n_coordinates], np.zeros(0))
        rest = model.rest(start, np.array([relative, mass]))
        np.testing.assert_allclose(rest.state, expected.state, atol=1e-12)
        np.testing.assert_allclose(rest.torque, expected.torque, rtol=1e-9)


@pytest.mark.parametrize("effect", ["gravity_error@body_2:relative=0.2", "backlash@motor_2:gap=1e-3"])
def test_runs_start_at_rest_with_laws_of_arm_and_gear_also_in_batches(effect: str) -> None:
    settings = {"robot": "elbow", "duration": 0.05, "feedforward": {"method": "none"}, "plant": {"effects": [effect]}}
    controller = {"kind": "pid", "kp": 0}
    experiment = Experiment.prepare(Scenario.model_validate({**settings, "controller": controller}))
    still = experiment.plant_in_time()
    for _ in range(50):
        still.advance(experiment.start_torque)
    assert np.max(np.abs(still.state - experiment.start_state)) < 1e-9
    name = next(iter(experiment.laws[0].parameters))
    value = experiment.laws[0].parameters[name]
    (record,) = batch(experiment, whole_record, values={name: [value]})
    single = experiment.plant_in_time()
    for sample in record.encoder:
        np.testing.assert_allclose(single.measure(), sample, atol=1e-12)
        single.advance([0.0, 0.0])
