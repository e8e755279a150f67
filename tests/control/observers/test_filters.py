"""Kalman filters: the errors that they make have the covariance that they predict."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.compile.loop.kernel import compile_loop
from flexros.control.base import AbstractControlLaw
from flexros.control.controller import Controller
from flexros.control.observers.base import AbstractObserver
from flexros.control.observers.extended_kalman import ExtendedKalman
from flexros.control.observers.kalman import Kalman
from flexros.control.state_feedback import StateFeedback
from flexros.errors import InputError
from flexros.robot import Robot, load_robot
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant import delayed_start
from flexros.simulate.plant_model import PlantModel

GAINS = {"motor_position": 2e4, "motor_speed": 500.0, "link_position": 0.0, "link_speed": 0.0}


def law_with(observer: AbstractObserver) -> StateFeedback:
    return StateFeedback.model_validate({**GAINS, "observer": observer})


def noisy_run(law: AbstractControlLaw, robot: Robot, n: int, torque: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the true states, shape (n, 2 nq), and the states of the controller before each sample, of a noisy run."""
    context = law.context(robot, robot.sample_time)
    controller, m = Controller(law, context), robot.n_motors
    rest = robot.equilibrium()
    reference = np.zeros(context.references.size)
    for name, rows in (("motor_position", robot.motor_rows), ("link_position", robot.gear_rows)):
        reference[context.references.rows(name)] = rest[list(rows)]
    reference[context.references.rows("feedforward_torque")] = held = robot.holding_torque(rest)
    model = PlantModel(robot, sensors=robot.further_sensors)
    size = context.measurements.size - m
    kernel = compile_loop(model.functions(feed_through(m, size)), sample_time=robot.sample_time, delay=robot.delay)
    step = kernel.stepper(delayed_start(model.start(rest, held), np.zeros(0), held, kernel.line_length))
    random = np.random.default_rng(7)
    rms = np.concatenate([robot.encoder_noise, *[[s.noise] * s.size for s in robot.further_sensors]])
    truth, states = [], []
    for _ in range(n):
        step.noise[:] = rms * random.standard_normal(len(rms))
        step.disturbance[:m] = torque * random.standard_normal(m)
        step.measure()
        truth.append(step.plant[: 2 * robot.n_coordinates] - rest)
        states.append(controller.state)
        step.command[:] = controller.step([*step.encoder, *step.further], reference)
        step.advance()
    return np.array(truth), np.array(states)


@pytest.mark.parametrize("name", ["two_mass", "four_mass_linear"])
def test_error_of_the_kalman_filter_has_the_covariance_of_its_design(name: str) -> None:
    robot, torque = load_robot(name), 2.0 if name == "two_mass" else 0.05
    observer = Kalman(torque_noise=torque)
    gains = GAINS if name == "two_mass" else {**GAINS, "motor_position": 8.0, "motor_speed": 0.3}
    law = StateFeedback.model_validate({**gains, "observer": observer})
    truth, states = noisy_run(law, robot, 8000, torque)
    model, _, after = observer.design(law.context(robot, robot.sample_time))
    motor = (model.G[:, :1] * torque**2) @ model.G[:, :1].T
    size = 2 * robot.n_coordinates
    ahead = (model.A @ after @ model.A.T + motor)[:size, :size]
    error = (truth - states[:, :size])[1000:]
    assert error.std(axis=0) == pytest.approx(np.sqrt(np.diag(ahead)), rel=0.2)
    assert np.max(np.abs(error.mean(axis=0)) / np.sqrt(np.diag(ahead))) < 0.3


def test_extended_filter_of_a_linear_robot_is_the_kalman_filter() -> None:
    robot, n = load_robot("two_mass"), 4
    observer = ExtendedKalman(torque_noise=2.0, load_noise=1e-6)
    law = law_with(observer)
    _, states = noisy_run(law, robot, 3000, 2.0)
    lower = states[-1][n : n + 10]
    found, begin = np.zeros((n, n)), 0
    for column in range(n):
        found[column:, column] = found[column, column:] = lower[begin : begin + n - column]
        begin += n - column
    model, _, after = Kalman(torque_noise=2.0).design(law.context(robot, robot.sample_time))
    ahead = model.A @ after @ model.A.T + 4.0 * model.G[:, :1] @ model.G[:, :1].T
    assert np.diag(found) == pytest.approx(np.diag(ahead), rel=0.02)


def test_errors_of_the_extended_filter_are_consistent_on_the_elbow() -> None:
    robot, n, torque = load_robot("elbow_sensors"), 8, 20.0
    gains = {"motor_position": [1.3e5, 5.6e4], "motor_speed": [4.1e3, 1.65e3], "link_position": 0, "link_speed": 0}
    observer = ExtendedKalman(torque_noise=torque, load_noise=1e-3)
    truth, states = noisy_run(StateFeedback.model_validate({**gains, "observer": observer}), robot, 3000, torque)
    squares = []
    for x, state in zip(truth[500:], states[500:], strict=True):
        covariance, begin = np.zeros((n, n)), n
        for column in range(n):
            covariance[column:, column] = covariance[column, column:] = state[begin : begin + n - column]
            begin += n - column
        error = x + robot.equilibrium() - state[:n]
        squares.append(error @ np.linalg.solve(covariance, error))
    assert np.mean(squares) == pytest.approx(n, rel=0.2)  # normalised errors are chi-squared


def test_too_many_states_and_missing_noise_are_refused() -> None:
    six = load_robot("six_axis")
    observer = ExtendedKalman(torque_noise=1.0, load_noise=1.0)
    with pytest.raises(InputError, match="48 states"):
        observer.check(law_with(observer).context(six, 5e-4))
    silent = load_robot("two_mass").spec.model_dump()
    silent["sensors"]["encoder_noise"]["value"] = 0.0
    from flexros.robot.robot import robot_from_data

    kalman = Kalman(torque_noise=1.0)
    with pytest.raises(InputError, match="motor_position"):
        kalman.check(law_with(kalman).context(robot_from_data(silent, "test"), 1e-3))
