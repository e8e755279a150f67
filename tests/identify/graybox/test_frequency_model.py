"""Frequency responses compared with python-control, and their Jacobian compared with differences."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.robot import Robot, load_robot
from flexros.robot.linear.linearise import linear_model
from flexros.robot.linear.positions import linearise_positions

FREQUENCY = np.array([0.7, 4.0, 11.0, 17.5, 30.0, 60.0, 90.0])


def model_of(name: str, parameters: list[str], number: int = 2, delay: float | None = None) -> FrequencyModel:
    robot: Robot = load_robot(name)
    rng = np.random.default_rng(1)
    motors = robot.home[list(robot.gear_rows)] + 0.3 * rng.normal(size=(number, robot.n_motors))
    positions = linearise_positions(robot, parameters, motors)
    return FrequencyModel(positions, FREQUENCY, robot.sample_time, robot.delay if delay is None else delay)


@pytest.mark.parametrize("name", ["two_mass", "e12", "four_mass_linear", "elbow"])
def test_response_without_sampling_is_that_of_the_state_space_model(name: str) -> None:
    model = model_of(name, ["motor_1.inertia"], 1)
    robot = load_robot(name)
    system = linear_model(robot, model.positions.coordinates[0][: robot.n_arm]).state_space()
    omega = 2 * np.pi * FREQUENCY
    expected = np.moveaxis(system(1j * omega)[: robot.n_motors], -1, 0)
    aliases = np.tensordot(model.hold.aliases[0], model.expansion[0], 1)
    continuous = (model.response(model.positions.values)[0] - aliases) / model.hold.gain[0][:, None, None]
    np.testing.assert_allclose(continuous, expected, rtol=1e-7)
    hold = np.exp(-1j * omega * (robot.delay + robot.sample_time / 2)) * np.sinc(FREQUENCY * robot.sample_time)
    np.testing.assert_allclose(model.hold.gain[0], -(omega**2) * hold, rtol=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("six_axis", ["body_2.rz.stiffness", "body_3.rx.damping", "motor_4.inertia", "motor_6.viscous_friction"]),
        ("e12", ["body_2.ry.stiffness", "body_3.ry.damping", "motor_1.inertia"]),
        ("four_mass", ["body_1.rz.stiffness", "body_2.rz.damping", "motor_1.inertia", "body_2.viscous_friction"]),
        ("elbow", ["body_1.mass", "body_2.center_of_mass.x", "body_1.length.z", "body_2.inertia.yy"]),
        ("emps", ["motor_1.inertia", "motor_1.viscous_friction"]),
    ],
)
def test_jacobian_is_that_of_differences(name: str, parameters: list[str]) -> None:
    model = model_of(name, parameters)
    theta = model.positions.values * np.linspace(0.8, 1.3, len(parameters))
    jacobian = model.jacobian(theta)
    assert jacobian.shape == (*model.response(theta).shape, len(parameters))
    for place in range(len(parameters)):
        step = 1e-4 * np.eye(len(parameters))[place]
        ends = [model.response(theta * np.exp(sign * step)) for sign in (1, -1)]
        expected = (ends[0] - ends[1]) / 2e-4
        np.testing.assert_allclose(jacobian[..., place], expected, atol=2e-6 * np.max(np.abs(expected)))


def test_jacobian_by_scaled_parameters() -> None:
    model = model_of("e12", ["body_1.ry.stiffness", "body_3.center_of_mass.x"])
    theta, scale = model.positions.values, np.array([3.0, 0.5])
    expected = model.jacobian(theta) / theta * scale
    np.testing.assert_allclose(model.jacobian(theta, scale), expected, rtol=1e-12)


@pytest.mark.slow
def test_response_is_symmetric() -> None:
    response = model_of("six_axis", ["body_2.rz.stiffness"]).response(np.array([1e6]))
    np.testing.assert_allclose(response, response.swapaxes(2, 3), rtol=1e-6, atol=1e-12 * np.max(np.abs(response)))


def test_positions_may_have_frequencies_of_their_own() -> None:
    common = model_of("e12", ["body_1.ry.stiffness"])
    theta = np.array([2e5])
    frequency = np.stack([FREQUENCY, FREQUENCY[::-1]])
    own = FrequencyModel(common.positions, frequency, common.sample_time, common.delay)
    np.testing.assert_allclose(own.response(theta)[0], common.response(theta)[0], rtol=1e-12)
    np.testing.assert_allclose(own.response(theta)[1], common.response(theta)[1, ::-1], rtol=1e-12)


def test_wrong_shape_of_frequencies_is_reported() -> None:
    positions = model_of("e12", ["body_1.ry.stiffness"]).positions
    with pytest.raises(InputError, match=r"frequencies have shape \(3, 4\), but 2 positions need one list"):
        FrequencyModel(positions, np.ones((3, 4)), 5e-4)
