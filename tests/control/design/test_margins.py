"""Margins of loops that are known in closed form, and against the stability limit itself."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.context import LoopContext
from flexros.control.design.closed_loop import largest_eigenvalues
from flexros.control.design.convert import law_from_control, law_to_control, plant_to_control
from flexros.control.design.margins import frequency_grid, loop_margins, loop_response, step_response
from flexros.control.design.methods.base import DesignProblem
from flexros.control.linear_controller import linear_controller
from flexros.control.pid import Pid
from flexros.errors import InputError
from flexros.robot import load_robot

PID = Pid(kp=24.0, ki=100.0, kd=2.35, derivative_filter=2.6e-3)


def test_gain_margin_is_where_the_loop_becomes_unstable() -> None:
    robot = load_robot("four_mass")
    problem = DesignProblem.of(robot)
    linear = linear_controller(PID, LoopContext(robot, robot.sample_time))
    for number, margins in enumerate(loop_margins(problem.sampled, linear)):
        for factor, inside in ((margins.gain_up, 0.99), (margins.gain_down, 1.01)):
            assert largest_eigenvalues(problem.sampled, linear, factor * inside)[number] < 1.0
            assert largest_eigenvalues(problem.sampled, linear, factor / inside)[number] > 1.0


def test_delay_margin_is_where_the_loop_becomes_unstable() -> None:
    robot = load_robot("four_mass_linear")
    linear = linear_controller(PID, LoopContext(robot, robot.sample_time))
    margins = loop_margins(DesignProblem.of(robot).sampled, linear)[0]
    for share, stable in ((0.97, True), (1.03, False)):
        later = DesignProblem.of(robot, delay=robot.delay + share * margins.delay).sampled
        assert bool(largest_eigenvalues(later, linear)[0] < 1.0) is stable


def test_step_settles_at_one_and_has_the_overshoot_of_the_figures() -> None:
    robot = load_robot("four_mass_linear")
    problem = DesignProblem.of(robot)
    linear = linear_controller(PID, LoopContext(robot, robot.sample_time))
    values = step_response(problem.sampled, linear, 0, 0, 8000)
    margins = loop_margins(problem.sampled, linear)[0]
    assert values[-1] == pytest.approx(1.0, abs=1e-3)
    assert np.max(values) - 1.0 == pytest.approx(margins.overshoot)
    late = values[round(margins.settling / robot.sample_time) :]
    assert np.max(np.abs(late - 1.0)) <= 0.02


def test_unconnected_integrator_of_a_pd_does_not_count() -> None:
    robot = load_robot("two_mass")
    linear = linear_controller(Pid(kp=2000.0, kd=100.0), LoopContext(robot, robot.sample_time))
    assert np.max(np.abs(np.linalg.eigvals(linear.state_step))) == 1.0
    assert largest_eigenvalues(DesignProblem.of(robot).sampled, linear)[0] < 1.0 - 1e-6


def test_several_motors_are_cut_one_at_a_time() -> None:
    robot = load_robot("e12")
    problem = DesignProblem.of(robot)
    linear = linear_controller(Pid(kp=135000.0, kd=9000.0), LoopContext(robot, robot.sample_time))
    margins = loop_margins(problem.sampled, linear)
    assert [entry.motor for entry in margins] == [0, 1]
    response = loop_response(problem.sampled, linear, frequency_grid(robot.sample_time))
    assert margins[1].sensitivity == pytest.approx(np.max(np.abs(1 / (1 + response.loop[0, :, 1]))))


def test_loop_of_control_objects_is_the_same() -> None:
    robot = load_robot("four_mass")
    problem = DesignProblem.of(robot)
    context = LoopContext(robot, robot.sample_time)
    frequency = np.array([1.0, 20.0, 300.0])
    loop = plant_to_control(problem.sampled, 2) * law_to_control(PID, context)
    found = loop_response(problem.sampled, linear_controller(PID, context), frequency).loop[2, :, 0]
    np.testing.assert_allclose(found, loop(np.exp(2j * np.pi * frequency * robot.sample_time)), rtol=1e-6)


def test_control_object_becomes_a_law_and_comes_back() -> None:
    import control

    robot = load_robot("two_mass")
    context = LoopContext(robot, robot.sample_time)
    system = control.tf([2.0, 30.0], [1e-3, 1.0])
    law = law_from_control(system, robot.sample_time)
    sampled = control.c2d(system, robot.sample_time, method="tustin")
    z = np.exp(2j * np.pi * 5.0 * robot.sample_time)
    assert law_to_control(law, context)(z) == pytest.approx(sampled(z))
    with pytest.raises(InputError, match=r"0\.01 s"):
        law_from_control(control.ss(0.5, 1.0, 1.0, 0.0, 0.01), robot.sample_time)
