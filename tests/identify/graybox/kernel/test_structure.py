"""Structure of compiled responses and the packing of their arrays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexros.identify.graybox.kernel.structure import (
    in_blocks,
    kernel_structure,
    motor_pairs,
    out_of_blocks,
    packed_matrices,
)
from flexros.identify.graybox.numpy_least_squares import ResponseTarget
from flexros.robot import load_robot
from flexros.robot.linear.positions import linearise_positions


def test_blocks_of_frequencies_go_both_ways() -> None:
    rng = np.random.default_rng(4)
    numbers = rng.normal(size=(2, 11, 3)) + 1j * rng.normal(size=(2, 11, 3))
    blocks = in_blocks(numbers.view(np.float64))
    assert blocks.shape == (2, 2, 6, 8)
    np.testing.assert_array_equal(out_of_blocks(blocks, 11), numbers)
    np.testing.assert_array_equal(blocks[:, 1, 0, 3:], np.repeat(numbers.real[:, -1:, 0], 5, axis=1))


def test_last_block_can_be_filled_with_a_number() -> None:
    blocks = in_blocks(np.ones((1, 3, 2)), fill=0.0)
    np.testing.assert_array_equal(blocks[0, 0], [[1, 1, 1, 0, 0, 0, 0, 0]] * 2)


def test_springs_and_dampers_of_one_location_share_their_vector() -> None:
    names = ["body_1.ry.stiffness", "body_1.ry.damping", "body_2.mass", "motor_2.inertia", "motor_2.viscous_friction"]
    structure = kernel_structure(linearise_positions(load_robot("elbow"), names, [[0.2, 0.3]]))
    assert structure.vectors == (((0, -1.0), (2, 1.0)), ((3, 1.0),))
    assert structure.parameters == ((0, 0), (0, 1), (2, 0), (1, 2), (1, 1))
    assert structure.n_slopes == 1
    assert structure.touched == (0, 1)
    assert [structure.elimination.order[turn] for turn in structure.sloped] == sorted(structure.touched)


def test_structure_does_not_depend_on_numbers() -> None:
    robot = load_robot("six_axis")
    names = robot.spec.unknown_parameters
    one = linearise_positions(robot, names, [[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]])
    other = linearise_positions(robot, names, [[-0.5, 0.1, 0.2, 0.9, 0.3, 1.0]], one.values * 1.3)
    assert kernel_structure(one) == kernel_structure(other)
    assert hash(kernel_structure(one)) == hash(kernel_structure(other))


def test_rounding_is_no_structure() -> None:
    positions = linearise_positions(load_robot("e12"), ["body_1.ry.stiffness"], [[0.1, 0.2]])
    noise = np.zeros_like(positions.stiffness)
    noise[:, 0, 4] = noise[:, 4, 0] = 1e-16 * positions.stiffness[0, 0, 0]
    noisy = replace(positions, stiffness=positions.stiffness + noise)
    assert kernel_structure(noisy) == kernel_structure(positions)
    assert kernel_structure(replace(positions, stiffness=positions.stiffness + 1e6 * noise)).entries != (
        kernel_structure(positions).entries
    )


def test_matrices_are_packed_in_the_order_of_entries() -> None:
    positions = linearise_positions(load_robot("e12"), ["body_1.ry.stiffness"], [[0.1, 0.2], [0.3, -0.4]])
    structure = kernel_structure(positions)
    theta = np.array([3e5])
    packed = packed_matrices(structure, positions, theta).reshape(2, -1, 3)
    mass, damping, stiffness = positions.matrices(theta)
    for number, (i, j) in enumerate(structure.entries):
        np.testing.assert_array_equal(packed[1, number], [stiffness[1, i, j], mass[1, i, j], damping[1, i, j]])


def test_pairs_of_motors() -> None:
    assert motor_pairs(3) == ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def packing_target(estimator: str) -> ResponseTarget:
    rng = np.random.default_rng(0)
    response = rng.normal(size=(2, 5, 2, 2)) + 1j * rng.normal(size=(2, 5, 2, 2))
    weights = rng.uniform(1, 2, response.shape)
    weights[0, 1] = 0.0
    return ResponseTarget(response, weights, estimator)


def test_pairs_hold_both_elements_and_the_sum_of_their_weights() -> None:
    target = packing_target("NLS")
    packed = target.packed.reshape(2, 1, 3, 8, 8)[1, 0, 1, :, 3]
    (a, b), (v, w) = (array[1, 3, [0, 1], [1, 0]] for array in (target.response, target.weights))
    np.testing.assert_allclose(packed, [a.real, a.imag, v, b.real, b.imag, w, np.sqrt(v + w), 1 / np.sqrt(v + w)])


def test_diagonal_elements_count_once() -> None:
    target = packing_target("LLS")
    packed = target.packed.reshape(2, 1, 3, 8, 8)[1, 0, 2, :, 0]
    log, w = np.log(target.response[1, 0, 1, 1]), target.weights[1, 0, 1, 1]
    np.testing.assert_allclose(packed[[0, 1, 2, 5, 6]], [log.real, log.imag, w, 0.0, np.sqrt(w)])


def test_elements_without_weight_and_padding_count_for_nothing() -> None:
    packed = packing_target("LLS").packed.reshape(2, 1, 3, 8, 8)
    assert np.all(packed[0, 0, :, [2, 5, 6, 7], 1] == 0.0)
    assert np.all(packed[..., 5:] == 0.0)
    assert np.all(np.isfinite(packed))


def test_a_target_is_packed_once() -> None:
    target = packing_target("LLS")
    assert target.packed is target.packed
