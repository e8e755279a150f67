"""Every design method against the law that defines it."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.context import LoopContext
from flexros.control.design.closed_loop import closed_loops, largest_eigenvalues
from flexros.control.design.continuous import ContinuousSystem, delayed_plant, pade, tustin
from flexros.control.design.methods.base import DesignProblem, design_methods
from flexros.control.design.methods.loop_shaping import LoopShaping, robust_stabiliser
from flexros.control.design.methods.lqg import Lqg
from flexros.control.design.methods.mixed_sensitivity import MixedSensitivity
from flexros.control.design.methods.mu_synthesis import MuSynthesis, fitted_scaling, mu_bounds
from flexros.control.design.methods.pole_placement import PolePlacement
from flexros.control.linear_controller import linear_controller
from flexros.errors import InputError
from flexros.robot import load_robot

FREQUENCY = np.geomspace(1e-3, 1e3, 4000)


def problem(robot: str) -> DesignProblem:
    return DesignProblem.of(load_robot(robot))


def test_problem_holds_every_segment_at_every_pose() -> None:
    robot = load_robot("four_mass")
    found = DesignProblem.of(robot, [robot.home, robot.home + 0.1])
    assert (len(found.plants), found.segments) == (10, 5)
    for share, index in ((0.0, 0), (1.0, 4)):
        np.testing.assert_allclose(found.plant_at(share).A[0], found.plants.A[index])


@pytest.mark.parametrize("name", ["four_mass_linear", "e12"])
def test_lqg_stabilises_its_design_model_with_a_phase_margin(name: str) -> None:
    given = problem(name)
    law = Lqg().design(given).law()
    linear = linear_controller(law, LoopContext(given.robot, given.sample_time))
    assert largest_eigenvalues(given.sampled, linear)[0] < 1.0


def test_lqg_regulator_and_filter_solve_their_riccati_equations() -> None:
    import control

    from flexros.control.design.methods.lqg import _filter, _regulator

    A, B = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.005], [0.1]])
    Q, R = np.diag([1.0, 0.1]), np.array([[0.2]])
    np.testing.assert_allclose(_regulator(A, B, Q, R), control.dlqr(A, B, Q, R)[0], rtol=1e-8)
    predictor = control.dlqe(A, np.eye(2), np.array([[1.0, 0.0]]), Q, R)[0]
    np.testing.assert_allclose(A @ _filter(A, np.array([[1.0, 0.0]]), Q, R), predictor, rtol=1e-8)


def test_placed_poles_are_those_of_the_loop() -> None:
    given = problem("four_mass")
    method = PolePlacement(bandwidth=15.0, damping=0.8, integral=12.0, observer_factor=3.0)
    law = method.design(given).law()
    linear = linear_controller(law, LoopContext(given.robot, given.sample_time))
    found = np.linalg.eigvals(closed_loops(given.sampled_at(method.stiffness_share), linear)[0])
    for pole in (15.0 * np.exp(1j * (np.pi - np.arccos(0.8))), 45.0 * np.exp(1j * (np.pi - np.arccos(0.8))), -12.0):
        assert np.min(np.abs(found - np.exp(pole * given.sample_time))) < 1e-6


def test_loop_shaping_reaches_its_gamma_and_no_less() -> None:
    plant = ContinuousSystem.of_polynomials([3.0, 30.0], [1.0, 0.4, 25.0, 0.0])
    controller, least = robust_stabiliser(plant, 1.02)
    G, K = plant.response(FREQUENCY)[:, 0, 0], -controller.response(FREQUENCY)[:, 0, 0]  # K for positive feedback
    norm = np.sqrt((1 + np.abs(K) ** 2) * (1 + np.abs(G) ** 2)) / np.abs(1 - G * K)
    assert np.max(norm) == pytest.approx(1.02 * least, rel=5e-3)
    n = len(plant.A)
    loop = np.block([[plant.A, plant.B @ controller.C], [-controller.B @ plant.C, controller.A]])
    assert loop.shape[0] == 2 * n
    assert np.max(np.linalg.eigvals(loop).real) < 0.0


def test_loop_shaping_of_an_integrator_has_the_known_margin() -> None:
    _, least = robust_stabiliser(ContinuousSystem.of_polynomials([1.0], [1.0, 0.0]), 1.1)
    assert least == pytest.approx(np.sqrt(2.0))


def test_mixed_sensitivity_reaches_its_gamma() -> None:
    pytest.importorskip("slycot")
    import control

    given = problem("four_mass_linear")
    method = MixedSensitivity()
    design = method.design(given)
    frequency = np.geomspace(1e-2, 200.0, 500)
    plant = delayed_plant(given, method.stiffness_share, "test")
    shifted = ContinuousSystem(plant.A - method.shift * np.eye(len(plant.A)), plant.B, plant.C, plant.D)
    G = shifted.response(frequency)[:, 0, 0]
    K = design.system.response(frequency, given.sample_time)[:, 0, 0]
    first, second, third = (weight(2j * np.pi * frequency) for weight in method.weights(control))
    norm = np.sqrt(np.abs(first) ** 2 + np.abs(second * K) ** 2 + np.abs(third * G * K) ** 2) / np.abs(1 + G * K)
    assert 0.8 * design.figures["gamma"] < np.max(norm) < 1.02 * design.figures["gamma"]


def test_h_infinity_methods_refuse_several_motors() -> None:
    with pytest.raises(InputError, match="one motor"):
        LoopShaping().design(problem("e12"))


def test_pade_delays_and_the_bilinear_transform_keeps_the_response() -> None:
    frequency = np.array([1.0, 10.0, 60.0])
    delay = pade(1e-3)
    np.testing.assert_allclose(delay.response(frequency)[:, 0, 0], np.exp(-2j * np.pi * frequency * 1e-3), atol=1e-4)
    discrete = tustin(delay, 5e-4).response(frequency, 5e-4)[:, 0, 0]
    warped = 2.0 / 5e-4 * np.tan(np.pi * frequency * 5e-4) / (2 * np.pi)
    np.testing.assert_allclose(discrete, delay.response(warped)[:, 0, 0], rtol=1e-9)


@pytest.mark.parametrize("name", sorted(design_methods()))
def test_every_choice_is_described_with_its_unit(name: str) -> None:
    method = design_methods()[name]
    assert set(method.tunable) <= set(method.model_fields)
    for key, field in method.model_fields.items():
        assert "[" in (field.description or ""), f"{name}.{key}"


def test_mu_bound_of_a_number_and_a_block_is_that_of_slicot() -> None:
    slycot = pytest.importorskip("slycot")
    rng = np.random.default_rng(1)
    M = rng.normal(size=(5, 3, 3)) + 1j * rng.normal(size=(5, 3, 3))
    bounds, _ = mu_bounds(M)
    for one, bound in zip(M, bounds, strict=True):
        expected = slycot.ab13md(one, np.array([1, 2]), np.array([2, 2]))[0]
        assert bound == pytest.approx(expected, rel=1e-4)


def test_scaling_of_first_order_is_found_again() -> None:
    frequency = np.geomspace(0.01, 100.0, 60)
    known = ContinuousSystem.of_polynomials([2.0, 60.0], [1.0, 4.0])
    found = fitted_scaling(np.abs(known.response(frequency)[:, 0, 0]), frequency)
    np.testing.assert_allclose(found.response(frequency), known.response(frequency), rtol=1e-4)


def test_mu_synthesis_keeps_its_performance_for_every_slope_of_the_spring() -> None:
    pytest.importorskip("slycot")
    given = problem("four_mass")
    method = MuSynthesis()
    design = method.design(given)
    peak = design.figures["peak of mu"]
    assert peak < 0.5 * design.figures["peak of mu, iteration 1"]
    linear = linear_controller(design.law(), LoopContext(given.robot, given.sample_time))
    assert np.all(largest_eigenvalues(given.sampled, linear) < 1.0)
    frequency = np.geomspace(0.05, 100.0, 300)
    K = design.system.response(frequency, given.sample_time)[:, 0, 0]
    weight = np.abs(1 + method.integral / (2j * np.pi * frequency)) * method.stiffness
    for share in (0.0, 0.3, 0.7, 1.0):
        P = delayed_plant(given, share, "test").response(frequency)[:, 0, 0]
        assert np.max(weight * np.abs(P / (1 + P * K))) < 1.1 * max(peak, 1.0)
