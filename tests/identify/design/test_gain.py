"""Gain of a design: efficiency and predicted deviations compared with random sets."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.design.d_optimal import d_optimal
from flexros.identify.design.gain import design_gain, predicted_deviation
from flexros.identify.design.rounding import round_design
from tests.identify.design.test_d_optimal import random_information


def test_design_is_better_than_every_random_set_and_not_better_than_the_optimum() -> None:
    information = random_information(300, 5)
    design = d_optimal(information)
    gain = design_gain(information, round_design(design, 12), design.log_det, seed=1)
    assert gain.random_efficiency[-1] < gain.efficiency <= 1
    assert len(gain.random_efficiency) == 200
    assert np.all(np.diff(gain.random_efficiency) >= 0)
    assert gain.experiments_saved == pytest.approx(gain.efficiency / np.median(gain.random_efficiency))


def test_deviations_are_those_of_all_experiments() -> None:
    information = np.array([np.diag([4.0, 1.0]), np.diag([0.0, 3.0])])
    gain = design_gain(information, np.array([4, 1]), 0.0, seed=1, number=3)
    assert gain.deviation == pytest.approx([1 / 4, 1 / np.sqrt(7)])


def test_deviation_is_infinite_without_information_and_right_for_any_scale() -> None:
    factor = np.array([[1.0, 0.0], [0.5, 1e-6]])
    assert predicted_deviation(factor @ factor.T) == pytest.approx(np.sqrt(np.diag(np.linalg.inv(factor @ factor.T))))
    assert np.all(np.isinf(predicted_deviation(np.diag([1.0, 0.0]))))
