"""Rest under gravity."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.config.yaml_file import read_yaml
from flexros.errors import InputError
from flexros.robot import load_robot, robot_from_data, robot_names
from flexros.robot.robot import LIBRARY

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", robot_names())
def test_nothing_moves_at_rest(name: str) -> None:
    robot = load_robot(name)
    state = robot.equilibrium(robot.home)
    rate = np.asarray(robot.model.derivative(state, robot.holding_torque(state), np.zeros(6), [])).ravel()
    np.testing.assert_allclose(rate, 0, atol=1e-9)


def test_actuated_coordinates_are_held_and_the_others_sag() -> None:
    robot = load_robot("six_axis")
    state = robot.equilibrium(robot.home)
    geared = list(robot.gear_rows)
    np.testing.assert_array_equal(state[geared], robot.home[geared])
    others = np.setdiff1d(np.arange(robot.n_arm), geared)
    assert np.abs(state[others]).max() > 1e-4


@pytest.mark.parametrize("name", ["e12", "elbow", "six_axis", "emps"])
def test_both_ways_of_asking_agree(name: str) -> None:
    robot = load_robot(name)
    state = robot.equilibrium(robot.home)
    motors = np.asarray(robot.model.encoder(state[: robot.n_coordinates])).ravel()
    np.testing.assert_allclose(robot.equilibrium(robot.home, motor_position=motors), state, atol=1e-10)


def test_torque_of_the_elbow_carries_its_weight() -> None:
    robot = load_robot("elbow")
    q = np.array([0.2, 0.3])
    state = robot.equilibrium(q)
    expected = robot.model.arm_inverse_dynamics(q, np.zeros(2), np.zeros(2), [])
    np.testing.assert_allclose(robot.holding_torque(state), np.asarray(expected).ravel(), rtol=1e-10)


@pytest.mark.parametrize("position", [[np.nan, 0.0], [0.1], [0.1, 0.2, 0.3]])
def test_motor_positions_that_are_none_are_refused(position: list[float]) -> None:
    with pytest.raises(InputError, match=r"robot elbow needs 2 finite numbers \(motor_1, motor_2\)"):
        load_robot("elbow").equilibrium(motor_position=position)


def test_a_search_that_ends_in_nan_is_no_rest() -> None:
    """A weight beyond all numbers leaves infinity minus infinity."""
    robot = load_robot("elbow").with_values({"gravity.z": -1e300, "body_1.mass": 1e300})
    with pytest.raises(InputError, match=r"no equilibrium at arm coordinates .* \(residual force nan"):
        robot.equilibrium()


def test_a_body_without_support_is_refused() -> None:
    data = read_yaml(LIBRARY / "elbow.yaml")
    data["bodies"][1]["directions"]["tz"] = {"spring": 0}
    data["home"] = [0, 0, 0]
    with pytest.raises(InputError, match="no equilibrium at arm coordinates"):
        robot_from_data(data, "loose").equilibrium()
