"""Plain arrays as experiments."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.estimate.estimate_response import frequency_response_of
from flexros.identify.frf.experiments import Experiments
from flexros.robot import load_robot

if TYPE_CHECKING:
    from flexros.identify.frf.quantity import Quantity


def test_one_input_and_output_may_be_plain_vectors() -> None:
    experiments = Experiments.of(np.arange(100.0), np.arange(100.0), 1e-2, n_periods=2, lines=[3, 1, 7])
    assert experiments.inputs.shape == (1, 100, 1)
    assert experiments.period == 50
    np.testing.assert_array_equal(experiments.excited, [1, 3, 7])
    np.testing.assert_array_equal(experiments.odd_detection, [5])
    np.testing.assert_array_equal(experiments.even_detection, [2, 4, 6])
    np.testing.assert_allclose(experiments.frequency, [2, 6, 14])


def test_blocks_hold_as_many_experiments_as_inputs() -> None:
    experiments = Experiments.of(np.zeros((6, 50, 3)), np.zeros((6, 50, 2)), 1e-2)
    np.testing.assert_array_equal(experiments.block, [0, 0, 0, 1, 1, 1])
    assert experiments.input_names == ("motor_1", "motor_2", "motor_3")


def test_band_chooses_lines() -> None:
    experiments = Experiments.of(np.zeros(1000), np.zeros(1000), 1e-3, band=(2.0, 4.0))
    np.testing.assert_array_equal(experiments.excited, [2, 3, 4])


def test_unequal_lengths_are_refused() -> None:
    with pytest.raises(InputError, match="outputs have 1 experiments of 40 samples, inputs 1 of 50, allowed are equal"):
        Experiments.of(np.zeros(50), np.zeros(40), 1e-2)


def test_band_without_lines_is_refused() -> None:
    with pytest.raises(
        InputError, match="a period of 100 samples of 0.01 s has no line in the band from 0.2 to 0.8 Hz"
    ):
        Experiments.of(np.zeros(100), np.zeros(100), 1e-2, band=(0.2, 0.8))


def test_values_that_are_not_finite_are_refused() -> None:
    with pytest.raises(InputError, match="inputs hold values that are not finite"):
        Experiments.of(np.full(50, np.nan), np.zeros(50), 1e-2)


def test_too_many_dimensions_are_refused() -> None:
    with pytest.raises(InputError, match="outputs have 4 dimensions, allowed are"):
        Experiments.of(np.zeros(50), np.zeros((1, 1, 50, 1)), 1e-2)


@pytest.mark.parametrize(("quantity", "place"), [("position", 3.0), ("velocity", np.nan), ("acceleration", np.nan)])
def test_mean_output_is_a_motor_position_only_where_outputs_are_positions(quantity: Quantity, place: float) -> None:
    t = np.arange(400)
    u = np.cos(2 * np.pi * 5 * t / 100)
    rng = np.random.default_rng(0)
    experiments = Experiments.of(
        u, 3.0 + u + 1e-3 * rng.standard_normal(400), 1e-2, n_periods=4, lines=[5], quantity=quantity
    )
    np.testing.assert_allclose(frequency_response_of(experiments).motor_position, [place], atol=1e-3)


def test_joints_of_outputs_that_are_no_positions_cannot_be_compared_with_the_robot() -> None:
    rng, t = np.random.default_rng(0), np.arange(800)
    multisine = np.cos(2 * np.pi * np.outer(t, [3, 5, 7]) / 200 + [0.0, 1.0, 4.0]).sum(axis=1)
    u = np.array([[multisine, multisine], [multisine, -multisine]]).swapaxes(1, 2)
    y = u @ np.array([[1.0, 0.2], [0.2, 0.8]]) + 1e-3 * rng.standard_normal(u.shape)
    experiments = Experiments.of(u, y, 1e-2, n_periods=4, lines=[3, 5, 7], quantity="velocity", label="position 1")
    warnings = frequency_response_of(experiments, robot=load_robot("e12")).warnings
    assert [warning for warning in warnings if "swapped or inverted" in warning] == [
        "position 1: the motor positions of motor_1, motor_2 are not known, because the outputs are no positions; "
        "whether joints are swapped or inverted was not checked against robot e12"
    ]
