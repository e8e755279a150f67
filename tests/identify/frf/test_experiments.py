"""Plain arrays as experiments."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.experiments import Experiments


def test_one_input_and_output_may_be_plain_vectors() -> None:
    mine = Experiments.of(np.arange(100.0), np.arange(100.0), 1e-2, n_periods=2, lines=[3, 1, 7])
    assert mine.inputs.shape == (1, 100, 1)
    assert mine.period == 50
    np.testing.assert_array_equal(mine.excited, [1, 3, 7])
    np.testing.assert_array_equal(mine.odd_detection, [5])
    np.testing.assert_array_equal(mine.even_detection, [2, 4, 6])
    np.testing.assert_allclose(mine.frequency, [2, 6, 14])


def test_blocks_hold_as_many_experiments_as_inputs() -> None:
    mine = Experiments.of(np.zeros((6, 50, 3)), np.zeros((6, 50, 2)), 1e-2)
    np.testing.assert_array_equal(mine.block, [0, 0, 0, 1, 1, 1])
    assert mine.input_names == ("motor_1", "motor_2", "motor_3")


def test_band_chooses_lines() -> None:
    mine = Experiments.of(np.zeros(1000), np.zeros(1000), 1e-3, band=(2.0, 4.0))
    np.testing.assert_array_equal(mine.excited, [2, 3, 4])


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
