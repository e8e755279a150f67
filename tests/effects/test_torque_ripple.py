"""Torque ripple repeats with the angle of the rotor."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects import parse_effect, place_effects
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario
from flexros.simulate.plant_model import PlantModel


def motor_torque(robot_name: str, effect: str, positions: FloatArray, command: float) -> FloatArray:
    """Read the added torque of motor 1 off the acceleration of its rotor, at rest."""
    robot = load_robot(robot_name)
    placed = place_effects(robot, [parse_effect(effect, "test")])
    with_effect, without = PlantModel(placed.robot, placed.laws).derivative, robot.model.derivative
    place = robot.motor_rows[0]
    inertia = robot.parameters["motor_1.inertia"].value
    u = np.zeros(robot.n_motors)
    u[0] = command
    torques = []
    for position in positions:
        x = np.zeros(2 * robot.n_coordinates)
        x[place] = position
        difference = with_effect(x, u, np.zeros(6), ca.DM(0, 1)) - without(x, u, np.zeros(6), ca.DM(0, 1))
        torques.append(inertia * float(difference[robot.n_coordinates + place]))
    return np.array(torques)


@pytest.mark.parametrize(("robot_name", "turns"), [("six_axis", 180.0), ("four_mass", 1.0), ("two_mass", 1.0)])
def test_order_counts_periods_per_turn_of_the_rotor(robot_name: str, turns: float) -> None:
    positions = np.linspace(0.0, 0.001, 7)
    text = "torque_ripple@motor_1:amplitude=5,order=6,phase=0.4"
    here, one_turn_on = (motor_torque(robot_name, text, positions + shift, 0.0) for shift in (0.0, 2 * np.pi / turns))
    np.testing.assert_allclose(here, 5 * np.sin(6 * turns * positions + 0.4), atol=1e-9)
    np.testing.assert_allclose(one_turn_on, here, atol=1e-9)


def test_proportional_ripple_scales_with_the_torque() -> None:
    text = "torque_ripple@motor_1:amplitude=0.02,order=6,phase=0.4,proportional=true"
    positions = np.array([0.0, 0.01])
    for command in (0.0, 100.0, -300.0):
        torque = motor_torque("two_mass", text, positions, command)
        np.testing.assert_allclose(torque, 0.02 * command * np.sin(6 * positions + 0.4), atol=1e-10)


@pytest.mark.parametrize("ripple", ["amplitude=9", "amplitude=0.2,proportional=true"])
def test_start_command_holds_a_plant_with_ripple_at_rest(ripple: str) -> None:
    effects = [f"torque_ripple@motor_{k}:{ripple},order=2,phase=1" for k in (1, 2)]
    settings = {"robot": "elbow", "duration": 0.1, "feedforward": {"method": "none"}, "plant": {"effects": effects}}
    experiment = Experiment.prepare(Scenario.model_validate({**settings, "controller": {"kind": "pid", "kp": 0}}))
    model, state = experiment.plant_model, experiment.start_state
    rate = model.derivative(model.start(state), experiment.start_torque, np.zeros(6), ca.DM(0, 1))
    np.testing.assert_allclose(rate.full(), 0.0, atol=1e-9)
    assert np.max(np.abs(experiment.start_torque - experiment.plant.holding_torque(state))) > 1


def test_proportional_ripple_as_large_as_the_torque_is_refused() -> None:
    with pytest.raises(InputError, match=r"amplitude is 2, but a proportional ripple .* must be below 1; lower it"):
        parse_effect("torque_ripple@motor_1:amplitude=2,proportional=true", "--effect")
