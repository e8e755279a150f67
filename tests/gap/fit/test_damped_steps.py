"""Damped steps: never beyond a bound or the longest step, and never upwards."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.damped_steps import best_step, may_move, predicted_fall
from flexros.gap.fit.linearisation import linearise
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.fit_data import FitData

TARGET = np.array([3.0, -0.5])


class Bowl:
    """Errors that are linear in two parameters, smallest at `TARGET`: predictor and log."""

    n_effect, tolerance, jumps, fineness, misfit = 2, Tolerance(), False, np.ones(2), 1.0
    bounds = (np.full(2, -1.0), np.full(2, 5.0))
    settings = SimpleNamespace(cores=1)

    def residuals(self, _: object, thetas: FloatArray) -> FloatArray:
        return np.asarray(10.0 * (thetas - TARGET[:, None]))


PREDICTOR, DATA = cast("Predictor", Bowl()), cast("FitData", Bowl())


def stepped(theta: FloatArray, longest: float) -> FloatArray:
    line = linearise(PREDICTOR, DATA, theta)
    return best_step(PREDICTOR, DATA, theta, line, longest, 0.0)[0]


def test_a_step_leads_to_the_minimum_of_a_linear_hypothesis() -> None:
    np.testing.assert_allclose(stepped(np.zeros(2), 10.0), TARGET, atol=1e-6)


def test_no_step_is_longer_than_the_longest() -> None:
    np.testing.assert_allclose(stepped(np.zeros(2), 1.0), TARGET / 3.0, atol=1e-6)


def test_a_parameter_at_its_bound_that_would_leave_it_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Bowl, "bounds", (np.full(2, 0.0), np.full(2, 5.0)))
    theta = np.zeros(2)
    line = linearise(PREDICTOR, DATA, theta)
    assert may_move(PREDICTOR, theta, line).tolist() == [True, False]
    np.testing.assert_allclose(stepped(theta, 10.0), [TARGET[0], 0.0], atol=1e-6)


def test_predicted_fall_is_that_of_a_linear_hypothesis() -> None:
    line = linearise(PREDICTOR, DATA, np.zeros(2))
    assert predicted_fall(line, np.ones(2, dtype=bool)) == pytest.approx(line.chi2)
    assert predicted_fall(line, np.array([True, False])) == pytest.approx(100.0 * TARGET[0] ** 2)
