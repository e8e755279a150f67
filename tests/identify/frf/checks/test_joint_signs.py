"""Joints whose direction is inverted in a log."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.checks.joint_signs import check_signs
from flexros.robot import Robot, load_robot
from tests.identify.frf.checks.test_joint_pairing import POSES, measured

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def six_axis() -> Robot:
    return load_robot("six_axis")


def signs(motor: int) -> np.ndarray:
    sign = np.ones(6)
    sign[motor] = -1
    return sign


@pytest.mark.parametrize("pose", POSES)
def test_right_directions_pass_although_springs_are_off(six_axis: Robot, pose: list[float]) -> None:
    check_signs(measured(six_axis, pose), six_axis, "position 1")
    springs = {name: 2.0 * six_axis.parameters[name].value for name in six_axis.parameters if "stiffness" in name}
    check_signs(measured(six_axis.with_values(springs), pose), six_axis, "position 1")


@pytest.mark.parametrize("motor", range(6))
def test_inverted_torque_is_named(six_axis: Robot, motor: int) -> None:
    mine = measured(six_axis, POSES[1])
    with pytest.raises(
        InputError, match=f"position 1: the response of motor_{motor + 1} to itself has the sign opposite"
    ):
        check_signs(replace(mine, response=mine.response * signs(motor)), six_axis, "position 1")


@pytest.mark.parametrize("motor", range(6))
def test_joint_inverted_altogether_is_named(six_axis: Robot, motor: int) -> None:
    mine = measured(six_axis, POSES[1])
    sign = signs(motor)
    turned = replace(mine, response=mine.response * sign[:, None] * sign, motor_position=mine.motor_position * sign)
    with pytest.raises(InputError, match=f"with the direction of motor_{motor + 1} inverted"):
        check_signs(turned, six_axis, "position 1")
