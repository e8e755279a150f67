"""Machine code compared with the frequency model in NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.identify.graybox.kernel.frequency_kernel import kernel_for
from flexros.identify.graybox.kernel.frequency_model import compiled_model
from flexros.identify.graybox.kernel.structure import kernel_structure
from flexros.robot import load_robot
from flexros.robot.linear.positions import linearise_positions

FREQUENCY = np.geomspace(0.5, 120.0, 13)  # not a multiple of the lanes
CASES = {
    "six_axis": (),
    "six_axis with inertias": ("body_7.mass", "body_3.ry.stiffness", "body_5.center_of_mass.x", "body_4.length.x"),
    "elbow with inertias": ("body_2.mass", "body_2.inertia.yy"),
    "four_mass with friction": ("body_2.viscous_friction", "body_1.rz.stiffness"),
    "e12": ("body_1.ry.stiffness", "body_1.ry.damping", "body_3.ry.stiffness", "motor_2.inertia"),
    "elbow": ("body_1.ry.stiffness", "body_2.ry.damping", "motor_1.viscous_friction"),
    "four_mass": ("body_1.rz.stiffness", "body_2.rz.stiffness", "body_3.rz.damping", "motor_1.inertia"),
    "two_mass": ("body_1.rz.damping",),
    "emps": ("motor_1.inertia", "motor_1.viscous_friction"),
}


def model_of(name: str, number: int = 3) -> FrequencyModel:
    robot = load_robot(name.split()[0])
    motors = robot.home[list(robot.gear_rows)] + 0.3 * np.random.default_rng(2).normal(size=(number, robot.n_motors))
    positions = linearise_positions(robot, CASES[name] or robot.spec.unknown_parameters, motors)
    return FrequencyModel(positions, FREQUENCY, robot.sample_time, robot.delay)


def shifted(model: FrequencyModel) -> np.ndarray:
    """Values up to a factor of ten away from those linearised at."""
    rng = np.random.default_rng(3)
    theta: np.ndarray = model.positions.values * 10.0 ** rng.uniform(-1, 1, len(model.positions.values))
    return np.where(model.positions.powers >= 0, theta, model.positions.values * rng.uniform(0.9, 1.1, len(theta)))


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_response_and_jacobian_are_those_of_numpy(name: str) -> None:
    model = model_of(name)
    compiled = compiled_model(model)
    assert compiled is not None
    theta = shifted(model)
    response, jacobian = model.response_and_jacobian(theta)
    assert compiled.factored_jacobian(theta) is not None
    np.testing.assert_allclose(compiled.response(theta), response, atol=1e-9 * np.max(np.abs(response)), rtol=1e-7)
    for diagonal, expected in zip(
        np.moveaxis(compiled.jacobian(theta), -1, 0), np.moveaxis(jacobian, -1, 0), strict=True
    ):
        np.testing.assert_allclose(diagonal, expected, atol=1e-9 * np.max(np.abs(expected)))


@pytest.mark.slow
def test_diagonal_elements_agree_to_nine_digits() -> None:
    model = model_of("six_axis")
    compiled = compiled_model(model)
    assert compiled is not None
    theta = shifted(model)
    diagonal, expected = (np.einsum("qfmm->qfm", m.response(theta)) for m in (compiled, model))
    np.testing.assert_allclose(diagonal, expected, rtol=1e-9)


def test_scale_of_parameters() -> None:
    model = model_of("e12")
    compiled = compiled_model(model)
    assert compiled is not None
    theta, scale = model.positions.values, np.array([2.0, 3.0, 4.0, 5.0])
    expected = model.jacobian(theta, scale)
    np.testing.assert_allclose(compiled.jacobian(theta, scale), expected, atol=1e-9 * np.max(np.abs(expected)))


def test_threads_share_the_positions_without_changing_a_bit() -> None:
    model = model_of("elbow", 5)
    one, two = compiled_model(model), compiled_model(model, threads=2)
    assert one is not None
    assert two is not None
    np.testing.assert_array_equal(two.response(model.positions.values), one.response(model.positions.values))


def test_positions_may_have_frequencies_of_their_own() -> None:
    common = model_of("e12", 2)
    frequency = np.stack([FREQUENCY, 0.7 * FREQUENCY])
    model = FrequencyModel(common.positions, frequency, common.sample_time, common.delay)
    compiled = compiled_model(model)
    assert compiled is not None
    theta = model.positions.values
    np.testing.assert_allclose(compiled.response(theta), model.response(theta), rtol=1e-8)


def test_linearisations_of_one_structure_share_code() -> None:
    first, second = model_of("e12", 2), model_of("e12", 3)
    assert kernel_for(kernel_structure(first.positions)) is kernel_for(kernel_structure(second.positions))


def test_vanishing_pivot_is_left_to_numpy() -> None:
    robot = load_robot("two_mass").with_values({"body_1.rz.damping": 0.0})
    positions = linearise_positions(robot, ["body_1.rz.stiffness"], [[0.0]])
    antiresonance = np.sqrt(6e4 / 6.0) / (2 * np.pi)
    model = FrequencyModel(positions, np.array([5.0, antiresonance, 20.0]), 1e-3)
    compiled = compiled_model(model)
    assert compiled is not None
    theta = positions.values
    assert compiled.factored_jacobian(theta) is None
    np.testing.assert_array_equal(compiled.response(theta), model.response(theta))
    np.testing.assert_array_equal(compiled.jacobian(theta), model.jacobian(theta))
    away = FrequencyModel(positions, np.array([5.0, 20.0]), 1e-3)
    compiled = compiled_model(away)
    assert compiled is not None
    assert compiled.factored_jacobian(theta) is not None
