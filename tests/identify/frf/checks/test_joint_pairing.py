"""Joints that were swapped in a log, found on the nominal six-axis robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.checks.joint_pairing import check_order, check_pairing, nominal_response
from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.robot import Robot, load_robot

FREQUENCY = np.arange(1.5, 60.0, 2.0)
POSES = ([0.0, 0.2, 0.1, 0.0, 0.6, 0.3], [0.5, 0.5, -0.4, 0.8, 0.9, -0.5], [-0.5, -0.3, 0.4, -0.7, -0.8, 0.6])


@pytest.fixture(scope="module")
def six_axis() -> Robot:
    return load_robot("six_axis")


def measured(robot: Robot, pose: list[float], seed: int = 0) -> FrequencyResponse:
    """The nominal response, off by 10 % at random."""
    n, n_f = robot.n_motors, len(FREQUENCY)
    names = tuple(f"motor_{i + 1}" for i in range(n))
    blank = FrequencyResponse(
        frequency=FREQUENCY,
        response=np.zeros((n_f, n, n), dtype=complex),
        noise_error=None,
        total_error=None,
        input_inverse=np.tile(np.eye(n, dtype=complex), (n_f, 1, 1)),
        degrees_of_freedom=0.0,
        input_names=names,
        output_names=names,
        input_units=("Nm",) * n,
        coordinate_units=("rad",) * n,
        gears=np.array(pose),
        motor_position=np.array(pose),
        sample_time=5e-4,
        n_periods=1,
        n_blocks=1,
    )
    rng = np.random.default_rng(seed)
    error = 0.1 * (rng.standard_normal((n_f, n, n)) + 1j * rng.standard_normal((n_f, n, n)))
    return replace(blank, response=nominal_response(blank, robot) * (1 + error))


@pytest.mark.parametrize("pose", POSES)
def test_right_order_passes(six_axis: Robot, pose: list[float]) -> None:
    mine = measured(six_axis, pose)
    check_pairing(mine, "position 1")
    check_order(mine, six_axis, "position 1")


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("swap", [(0, 1), (1, 2), (4, 5), (0, 5)])
def test_commands_of_another_joint_are_found_without_a_robot(
    six_axis: Robot, pose: list[float], swap: tuple[int, int]
) -> None:
    mine = measured(six_axis, pose)
    order = np.arange(6)
    order[list(swap)] = order[list(swap)[::-1]]
    first, second = (f"motor_{i + 1}" for i in swap)
    with pytest.raises(InputError, match=f"position 1: swapped joints: the command of {first} moves {second}, not the"):
        check_pairing(replace(mine, response=mine.response[:, :, order]), "position 1")


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("swap", [(1, 2), (3, 4), (0, 5)])
def test_joints_swapped_in_commands_and_positions_are_found_with_the_robot(
    six_axis: Robot, pose: list[float], swap: tuple[int, int]
) -> None:
    mine = measured(six_axis, pose)
    order = np.arange(6)
    order[list(swap)] = order[list(swap)[::-1]]
    swapped = replace(mine, response=mine.response[:, order][:, :, order], motor_position=mine.motor_position[order])
    check_pairing(swapped, "position 1")
    first, second = (f"motor_{i + 1}" for i in swap)
    with pytest.raises(InputError, match=f"swapped joints: .*{first} behaves like {second}.* of robot six_axis"):
        check_order(swapped, six_axis, "position 1")


def test_one_motor_has_no_order() -> None:
    robot = load_robot("two_mass")
    mine = measured(robot, [0.0])
    check_pairing(mine, "position 1")
    check_order(mine, robot, "position 1")
