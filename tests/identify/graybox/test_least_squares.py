"""Normal equations compared with differences of the cost, and machine code compared with NumPy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.identify.graybox.kernel.least_squares import CompiledLeastSquares
from flexros.identify.graybox.least_squares import ResponseTarget, least_squares
from flexros.identify.graybox.numpy_least_squares import NumpyLeastSquares
from flexros.robot import load_robot
from flexros.robot.linear.positions import linearise_positions

if TYPE_CHECKING:
    from flexros.prediction.damped_least_squares import NormalEquations

FREQUENCY = np.geomspace(1.0, 100.0, 21)
CASES = {
    "six_axis": (),
    "elbow": ("body_2.mass", "body_1.ry.stiffness", "body_2.ry.damping", "body_2.center_of_mass.x", "body_1.length.z"),
    "e12": ("body_1.ry.stiffness", "body_1.ry.damping", "body_3.ry.damping", "motor_2.inertia", "motor_1.inertia"),
    "four_mass": ("body_1.rz.stiffness", "body_2.rz.stiffness", "body_3.rz.damping", "motor_1.viscous_friction"),
}
ESTIMATORS = ("LLS", "LLSM", "NLS")


def model_of(name: str, parameters: tuple[str, ...] = ()) -> FrequencyModel:
    robot = load_robot(name)
    motors = robot.home[list(robot.gear_rows)] + 0.3 * np.random.default_rng(0).normal(size=(3, robot.n_motors))
    positions = linearise_positions(robot, parameters or CASES[name] or robot.spec.unknown_parameters, motors)
    return FrequencyModel(positions, FREQUENCY, robot.sample_time, robot.delay)


def target_of(model: FrequencyModel, estimator: str) -> ResponseTarget:
    """Noisy responses of the nominal values with random weights, a fifth of them zero with nothing measured there."""
    rng = np.random.default_rng(1)
    response = model.response(model.positions.values)
    response = response * np.exp(0.2 * rng.normal(size=response.shape) + 1j * rng.normal(size=response.shape))
    weights = rng.uniform(0.5, 2.0, response.shape) * (rng.uniform(size=response.shape) > 0.2)
    if estimator == "NLS":
        weights /= np.mean(np.abs(response), axis=(0, 1)) ** 2
    return ResponseTarget(np.where(weights > 0, response, np.nan), weights, estimator)


def shifted(model: FrequencyModel) -> np.ndarray:
    size = len(model.positions.values)
    spread = np.where(model.positions.powers >= 0, 0.3, 0.03)
    theta: np.ndarray = model.positions.values * np.exp(spread * np.random.default_rng(2).normal(size=size))
    return theta


def assert_equal(actual: NormalEquations, expected: NormalEquations, tolerance: float = 1e-9) -> None:
    sizes = np.sqrt(np.diag(expected.hessian))
    assert actual.cost == pytest.approx(expected.cost, rel=tolerance)
    assert np.max(np.abs(actual.gradient - expected.gradient) / (sizes * np.sqrt(expected.cost))) < tolerance
    assert np.max(np.abs(actual.hessian - expected.hessian) / np.outer(sizes, sizes)) < tolerance


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("name", CASES)
def test_machine_code_gives_the_normal_equations_of_numpy(name: str, estimator: str) -> None:
    model = model_of(name)
    target, theta = target_of(model, estimator), shifted(model)
    squares = least_squares(model, target)
    assert isinstance(squares, CompiledLeastSquares)
    oracle = NumpyLeastSquares(model, target)
    assert squares.cost(theta) == pytest.approx(oracle.cost(theta), rel=1e-9)
    assert_equal(squares.normal_equations(theta), oracle.normal_equations(theta))
    assert_equal(squares.normal_equations(2 * theta), oracle.normal_equations(2 * theta))
    scale = np.linspace(1.0, 2.0, len(theta))
    assert_equal(squares.normal_equations(theta, scale), oracle.normal_equations(theta, scale))


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("name", ["e12", "elbow"])
def test_gradient_is_that_of_differences_of_the_cost(name: str, estimator: str) -> None:
    model = model_of(name)
    squares, theta = least_squares(model, target_of(model, estimator)), shifted(model)
    gradient = squares.normal_equations(theta).gradient
    for place, slope in enumerate(gradient):
        step = np.exp(1e-5 * np.eye(len(theta))[place])
        difference = (squares.cost(theta * step) - squares.cost(theta / step)) / 2e-5
        assert difference == pytest.approx(slope, rel=1e-5, abs=1e-6 * np.max(np.abs(gradient)))


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_hessian_is_that_of_differences_of_the_gradient_where_the_errors_vanish(estimator: str) -> None:
    model = model_of("e12")
    theta = model.positions.values
    response = model.response(theta)
    weights = 1.0 / np.abs(response) ** 2 if estimator == "NLS" else np.ones(response.shape)
    squares = least_squares(model, ResponseTarget(response, weights, estimator))
    equations = squares.normal_equations(theta)
    assert equations.cost < 1e-12
    for place, row in enumerate(equations.hessian):
        step = np.exp(1e-4 * np.eye(len(theta))[place])
        ends = [squares.normal_equations(theta * step).gradient, squares.normal_equations(theta / step).gradient]
        np.testing.assert_allclose((ends[0] - ends[1]) / 2e-4, row, atol=1e-4 * np.max(np.abs(equations.hessian)))


def test_phase_errors_are_taken_within_half_a_turn() -> None:
    model = model_of("e12")
    theta = model.positions.values
    turned = model.response(theta) * np.exp(3.1j)
    weights = np.ones(turned.shape)
    cost = least_squares(model, ResponseTarget(turned, weights, "LLS")).cost(theta)
    assert cost == pytest.approx(3.1**2 * turned.size)
    assert least_squares(model, ResponseTarget(turned, weights, "LLSM")).cost(theta) == pytest.approx(0.0, abs=1e-12)


def test_threads_change_nothing() -> None:
    model = model_of("e12")
    target, theta = target_of(model, "LLS"), shifted(model)
    single, double = (least_squares(model, target, threads).normal_equations(theta) for threads in (1, 2))
    assert single.cost == double.cost
    np.testing.assert_array_equal(single.hessian, double.hessian)


def test_vanishing_pivot_is_left_to_numpy() -> None:
    robot = load_robot("two_mass").with_values({"body_1.rz.damping": 0.0})
    positions = linearise_positions(robot, ["body_1.rz.stiffness", "motor_1.inertia"], [[0.0]])
    antiresonance = np.sqrt(6e4 / 6.0) / (2 * np.pi)
    model = FrequencyModel(positions, np.array([5.0, antiresonance, 20.0]), 1e-3)
    target = ResponseTarget(np.ones((1, 3, 1, 1), complex), np.ones((1, 3, 1, 1)), "NLS")
    squares, oracle = least_squares(model, target), NumpyLeastSquares(model, target)
    assert isinstance(squares, CompiledLeastSquares)
    assert squares.cost(positions.values) == oracle.cost(positions.values)
    assert_equal(squares.normal_equations(positions.values), oracle.normal_equations(positions.values), 1e-15)


def test_without_compiler_numpy_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros.identify.graybox.kernel.frequency_kernel.can_compile", lambda: False)
    model = model_of("e12")
    target = target_of(model, "LLS")
    squares = least_squares(model, target)
    assert isinstance(squares, NumpyLeastSquares)
    assert squares.cost(shifted(model)) > 0


def test_wrong_shape_is_reported() -> None:
    model = model_of("e12")
    with pytest.raises(
        InputError, match=r"weights have shape \(2,\), but the model of robot e12 needs \(3, 21, 2, 2\)"
    ):
        least_squares(model, ResponseTarget(np.ones((3, 21, 2, 2), complex), np.ones(2), "LLS"))


def test_negative_weight_is_reported() -> None:
    model = model_of("e12")
    ones = np.ones((3, 21, 2, 2))
    with pytest.raises(InputError, match="weights of frequency responses must be finite and not negative"):
        least_squares(model, ResponseTarget(ones + 0j, -ones, "LLS"))


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_weight_on_nothing_is_reported(value: float) -> None:
    model = model_of("e12")
    response = np.ones((3, 21, 2, 2), complex)
    response[1, 2, 0, 1] = value
    with pytest.raises(InputError, match="1 elements of the measured responses are zero or not finite but have a weig"):
        least_squares(model, ResponseTarget(response, np.ones(response.shape), "LLS"))


def test_unknown_estimator_is_reported() -> None:
    model = model_of("e12")
    ones = np.ones((3, 21, 2, 2))
    with pytest.raises(InputError, match="LSS"):
        least_squares(model, ResponseTarget(ones + 0j, ones, "LSS"))
