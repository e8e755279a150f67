"""Compiled time stepping against slow oracles: the CasADi virtual machine, and SciPy's fsolve on plain formulas."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import fsolve

from flexros.arrays import FloatArray
from flexros.feedforward.time_stepping.compiled import CompiledStepper
from flexros.feedforward.time_stepping.dae_equations import build_equations
from flexros.feedforward.time_stepping.interpreted import InterpretedStepper
from flexros.feedforward.time_stepping.step_functions import StepFunctions
from flexros.feedforward.time_stepping.stepping import MAX_ITERATIONS, Stepper, newton_tolerance
from flexros.robot import Robot
from tests.feedforward.cases import smooth_circle

pytestmark = pytest.mark.slow

STEP = 1e-3
START = np.array([0, 0.3, 0, 0, 0.3])


def steppers(robot: Robot, order: int, exact: bool = True) -> tuple[CompiledStepper, InterpretedStepper, FloatArray]:
    equations = build_equations(robot.model, exact=exact)
    functions = StepFunctions.of(equations, order, STEP)
    tolerance = newton_tolerance(equations, functions.gamma, START)
    return CompiledStepper(equations, functions), InterpretedStepper(equations, functions), tolerance


def by_fsolve(robot: Robot, outputs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Backward Euler as in Paper B: fsolve with finite differences on equations 8a and 8d, torque from equation 2b."""
    model, p = robot.model, robot.model.parameter_values
    gamma = model.output()
    q, v = START, np.zeros(5)
    positions, torques = [], []
    scale = np.array([1e-6, 1e-6, 1e-6, 1.0, 1.0])

    def rates(new: FloatArray) -> tuple[FloatArray, FloatArray]:
        speed = (new - q) / STEP
        return speed, (speed - v) / STEP

    def missing(new: FloatArray, output: FloatArray) -> FloatArray:
        speed, acceleration = rates(new)
        force = np.array(model.force(new, speed, np.zeros(2), np.zeros(6), p)).ravel()
        balance = np.array(model.mass_matrix(new, p)) @ acceleration - force
        return scale * np.concatenate([balance[:3], np.array(gamma(new[:3], p)).ravel() - output])

    for output in outputs:
        guess = q + STEP * v
        new, *_ = fsolve(missing, guess, (output,), xtol=1e-14, full_output=True)  # goes on until it cannot improve
        speed, acceleration = rates(new)
        force = np.array(model.force(new, speed, np.zeros(2), np.zeros(6), p)).ravel()
        torques.append((np.array(model.mass_matrix(new, p)) @ acceleration - force)[3:])
        positions.append(new)
        q, v = new, speed
    return np.array(positions), np.array(torques)


@pytest.mark.parametrize("order", [1, 2])
def test_compiled_equals_interpreted(order: int, e12: Robot) -> None:
    compiled, interpreted, tolerance = steppers(e12, order)
    outputs = smooth_circle(np.arange(200) * STEP + 0.3) - smooth_circle(np.array(0.3)) + smooth_circle(np.array(0.0))
    fast = compiled.advance(compiled.layout.at_rest(START), outputs, tolerance)
    slow = interpreted.advance(interpreted.layout.at_rest(START), outputs, tolerance)
    assert fast.failed == slow.failed == 200
    np.testing.assert_allclose(fast.z, slow.z, atol=2e-11)
    np.testing.assert_allclose(fast.motors[:, 0], slow.motors[:, 0], atol=2e-6 * np.abs(slow.motors[:, 0]).max())


def test_backward_euler_equals_fsolve(e12: Robot) -> None:
    compiled, _, tolerance = steppers(e12, 1)
    outputs = smooth_circle(np.arange(0, 120) * STEP)
    fast = compiled.advance(compiled.layout.at_rest(START), outputs, tolerance)
    positions, torques = by_fsolve(e12, outputs)
    np.testing.assert_allclose(fast.z, positions, atol=1e-9)
    np.testing.assert_allclose(fast.motors[:, 0], torques, atol=0.5)  # what fsolve leaves in q_m, over the step squared


@pytest.mark.parametrize("kind", [0, 1])
def test_state_resumes_bit_for_bit(kind: int, e12: Robot) -> None:
    *both, tolerance = steppers(e12, 2)
    stepper: Stepper = both[kind]
    outputs = smooth_circle(np.arange(60) * STEP)
    whole = stepper.advance(stepper.layout.at_rest(START), outputs, tolerance)
    first = stepper.advance(stepper.layout.at_rest(START), outputs[:23], tolerance)
    second = stepper.advance(first.state, outputs[23:], tolerance)
    np.testing.assert_array_equal(np.concatenate([first.motors, second.motors]), whole.motors)
    np.testing.assert_array_equal(second.state, whole.state)


@pytest.mark.parametrize("kind", [0, 1])
def test_state_is_left_as_it_was(kind: int, e12: Robot) -> None:
    *both, tolerance = steppers(e12, 1)
    stepper: Stepper = both[kind]
    state = stepper.layout.at_rest(START)
    before = state.copy()
    stepper.advance(state, smooth_circle(np.arange(10) * STEP), tolerance)
    np.testing.assert_array_equal(state, before)


@pytest.mark.parametrize("kind", [0, 1])
@pytest.mark.parametrize("wrong", [10.0, np.nan])
def test_failed_step_is_reported(kind: int, wrong: float, e12: Robot) -> None:
    *both, tolerance = steppers(e12, 1)
    stepper: Stepper = both[kind]
    outputs = smooth_circle(np.arange(10) * STEP)
    outputs[6] = wrong
    result = stepper.advance(stepper.layout.at_rest(START), outputs, tolerance)
    assert result.failed == 6
    assert result.iterations[6] > MAX_ITERATIONS
    assert np.all(np.isfinite(result.z[:6]))


def test_mass_based_matrix_gives_the_same_solution(e12: Robot) -> None:
    outputs = smooth_circle(np.arange(400) * STEP)
    results = []
    for exact in (True, False):
        compiled, _, tolerance = steppers(e12, 2, exact)
        results.append(compiled.advance(compiled.layout.at_rest(START), outputs, tolerance))
    np.testing.assert_allclose(results[1].z, results[0].z, atol=2e-11)
    assert results[1].iterations.mean() < results[0].iterations.mean() + 1.0


def test_few_iterations_are_needed(e12: Robot) -> None:
    compiled, _, tolerance = steppers(e12, 2)
    result = compiled.advance(compiled.layout.at_rest(START), smooth_circle(np.arange(800) * STEP), tolerance)
    assert result.iterations.mean() < 3.5
    assert result.iterations.max() <= 6
