"""Linear models with an input that is held."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.robot.linear.held_input import held_input


def test_a_falling_mass_with_friction_moves_by_its_closed_form() -> None:
    rate, time = 0.7, 0.3
    step, entry = held_input(np.array([[0.0, 1.0], [0.0, -rate]]), np.array([[0.0], [1.0]]), time)
    decay = np.exp(-rate * time)
    assert step == pytest.approx(np.array([[1.0, (1 - decay) / rate], [0.0, decay]]), rel=1e-13)
    assert entry[:, 0] == pytest.approx([(time - (1 - decay) / rate) / rate, (1 - decay) / rate], rel=1e-13)


def test_several_models_are_those_of_each_one() -> None:
    random = np.random.default_rng(1)
    A, B = random.normal(size=(3, 4, 4)), random.normal(size=(3, 4, 2))
    together = held_input(A, B, 0.1)
    for index in range(3):
        for whole, own in zip(together, held_input(A[index], B[index], 0.1), strict=True):
            np.testing.assert_array_equal(whole[index], own)
