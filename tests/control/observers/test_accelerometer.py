"""The accelerometer observer: its error decays as designed, and does not depend on the inertia of the links."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from flexros.control.controller import Controller
from flexros.control.observers.accelerometer import AccelerometerObserver, correction
from flexros.control.state_feedback import StateFeedback
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

LAW = StateFeedback.model_validate(
    {
        "motor_position": 0.0,
        "motor_speed": 0.0,
        "link_position": 0.0,
        "link_speed": 0.0,
        "observer": AccelerometerObserver(bandwidth=60.0),
    }
)


def gain_of(A: np.ndarray, pole: float) -> np.ndarray:
    p = casadi.SX.sym("p")
    return np.asarray(casadi.Function("l", [p], [correction(A, p)])(pole).full()).ravel()


def test_error_of_each_joint_has_its_four_poles() -> None:
    robot = load_robot("elbow_sensors")
    context = LAW.context(robot, robot.sample_time)
    for motor in range(2):
        A, _ = LAW.observer.matrices(context, motor)  # type: ignore[attr-defined]
        pole = np.exp(-60.0 * robot.sample_time)
        error = A @ (np.eye(4) - np.outer(gain_of(A, pole), [1.0, 0.0, 0.0, 0.0]))
        assert np.poly(error) == pytest.approx(np.poly([pole] * 4), rel=1e-7)


@pytest.mark.slow
def test_a_wrong_start_is_forgotten_as_designed() -> None:
    scenario = load_scenario("elbow_accelerometer").with_values({"noise": False, "sample_time": 1e-4, "duration": 0.2})
    run = Experiment.prepare(scenario.with_values({"controller.observer.bandwidth": 60.0}))
    plant, controller, n = run.plant_in_time(), run.controller(), 1500
    law, context = run.scenario.controller, run.loop_context
    assert isinstance(law, StateFeedback)
    wrong = np.array([0.0, 0.0, 0.0, 0.0, 1e-4, -2e-4, 0.0, 0.0])  # of [q_m, q_m', q_a, q_a'] of both joints
    errors = []
    for k, reference in enumerate(run.reference_signal[:n]):
        truth = plant.state
        errors.append(controller.state[:8] - truth[[2, 3, 6, 7, 0, 1, 4, 5]])
        plant_values = [*plant.measure(), *plant.further()]
        plant.advance(controller.step(plant_values, reference))
        if k == 0:
            controller.state = controller.state + np.concatenate([wrong, np.zeros(len(controller.state) - 8)])
    predicted = np.zeros((2, 4))
    A = [law.observer.matrices(context, motor) for motor in range(2)]  # type: ignore[attr-defined]
    for motor in range(2):
        predicted[motor] = wrong[motor::2]
    for k in range(1, 1000):
        error = np.array(errors[k]).reshape(4, 2).T
        assert np.max(np.abs(error - predicted)[:, [0, 2]]) < 2e-6  # the hold of the acceleration is left
        for motor, (step, _) in enumerate(A):
            gain = gain_of(step, np.exp(-60.0 * context.sample_time))
            predicted[motor] = step @ (predicted[motor] - gain * predicted[motor, 0])
    assert np.max(np.abs(np.array(errors)[1:50, 4:6])) > 5e-5


def test_a_wrong_link_mass_does_not_mislead_it() -> None:
    changed = {"noise": False, "plant.values.body_2.mass": 60.0}
    run = Experiment.prepare(load_scenario("elbow_accelerometer").with_values(changed))
    plant, controller = run.plant_in_time(), run.controller()
    error = []
    for k, reference in enumerate(run.reference_signal[:4000]):
        if k > 500:
            error.append(np.abs(controller.state[4:6] - plant.state[:2]))
        plant.advance(controller.step([*plant.measure(), *plant.further()], reference))
    deflection = np.abs(plant.state[:2] - plant.state[2:4])
    assert np.max(deflection) > 5e-4
    assert np.max(error) < 0.05 * np.max(deflection)


def test_run_in_process_is_that_of_the_controller() -> None:
    run = Experiment.prepare(load_scenario("elbow_accelerometer").with_values({"duration": 0.1}))
    log, plant, controller = closed_loop(run), run.plant_in_time(), run.controller()
    assert isinstance(controller, Controller)
    commands = []
    for reference in run.reference_signal:
        commands.append(controller.step([*plant.measure(), *plant.further()], reference))
        plant.advance(commands[-1])
    assert log.joint_commands is not None
    assert np.array_equal(log.joint_commands.effort, commands)  # type: ignore[arg-type]


@pytest.mark.parametrize(("name", "text"), [("elbow", "accelerometer"), ("e12", "accelerometer")])
def test_robots_without_the_sensor_are_refused(name: str, text: str) -> None:
    with pytest.raises(InputError, match=text):
        LAW.check(LAW.context(load_robot(name), 5e-4))
