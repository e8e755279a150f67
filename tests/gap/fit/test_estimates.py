"""Fitted numbers in the units of their effects."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.estimates import covariance_of, parameters_of, placed
from flexros.gap.fit.least_squares import CandidateFit
from tests.gap.diagnosis_logs import candidates_of, numbers, predictor_of


@pytest.fixture(name="fitted", scope="module")
def fitted_fixture() -> CandidateFit:
    """Coulomb friction by its logarithm, known to 10 %, and a stiffness to 0.02, beside a tolerated number."""
    pair = [candidates_of()[name] for name in ("coulomb_friction@motor_1", "stiffness_error@body_2.rz")]
    predictor = predictor_of(*pair, tolerance=Tolerance(("body_1.rz.stiffness",), (0.02,)))
    theta = np.array([*numbers(pair[0], level=0.05), *numbers(pair[1], relative=-0.1), 0.5])
    scale = np.array([0.1, 0.02 / pair[1].free[0].high, 0.8])
    correlation = np.array([[1.0, 0.5, 0.2], [0.5, 1.0, 0.1], [0.2, 0.1, 1.0]])
    return CandidateFit(predictor, theta, 1.0, np.linalg.inv(correlation * np.outer(scale, scale)))


def test_effects_have_their_numbers(fitted: CandidateFit) -> None:
    assert [(str(one).partition(":")[0]) for one in placed(fitted)] == [
        "coulomb_friction@motor_1",
        "stiffness_error@body_2.rz",
    ]
    (friction, soft) = parameters_of(fitted)
    assert friction["level"].value == pytest.approx(0.05)
    assert (friction["level"].unit, soft["relative"].unit) == ("Nm", "1")
    assert soft["relative"].value == pytest.approx(-0.1)


def test_deviations_are_in_the_units_of_the_numbers(fitted: CandidateFit) -> None:
    friction, soft = parameters_of(fitted)
    assert friction["level"].std == pytest.approx(0.1 * 0.05)
    assert soft["relative"].std == pytest.approx(0.02)


def test_covariance_keeps_correlations_and_leaves_tolerated_numbers_out(fitted: CandidateFit) -> None:
    names, covariance = covariance_of(fitted)
    assert names == ("coulomb_friction@motor_1.level", "stiffness_error@body_2.rz.relative")
    assert covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1]) == pytest.approx(0.5)
