"""Candidates in place of deviations beyond tolerance."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.tolerance_takeover import takeover, with_takeover
from tests.gap.diagnosis_logs import candidates_of, predictor_of

STIFFNESS = "stiffness_error@body_2.rz"
NAMES = ("body_1.rz.stiffness", "body_2.rz.stiffness", "body_2.rz.damping")


def beyond_tolerance() -> CandidateFit:
    predictor = predictor_of(tolerance=Tolerance(NAMES, (0.03, 0.03, 0.3)))
    return CandidateFit(predictor, np.array([1.0, -4.0, 2.0]), 1e4)


def test_a_changed_parameter_takes_over_its_own_deviation() -> None:
    candidate = candidates_of()[STIFFNESS]
    found = takeover(candidate, beyond_tolerance())
    assert found is not None
    assert found.gain == 16.0
    assert found.replaced.tolist() == [False, True, False]
    (free,) = candidate.free
    assert 1 + float(free.decode(found.start)[0]) == pytest.approx(np.exp(-4.0 * 0.03))


@pytest.mark.parametrize("name", ["coulomb_friction@motor_1", "stiffness_error@body_3.rz"])
def test_others_take_over_nothing(name: str) -> None:
    assert takeover(candidates_of()[name], beyond_tolerance()) is None


def test_the_larger_gain_gives_the_initial_value() -> None:
    candidate, first = candidates_of()[STIFFNESS], beyond_tolerance()
    chosen = with_takeover(candidate, first, 3.0, np.array([0.5]))
    assert chosen.gain == 16.0
    assert chosen.replaced.any()
    chosen = with_takeover(candidate, first, 30.0, np.array([0.5]))
    assert chosen.gain == 30.0
    assert chosen.start.tolist() == [0.5]
    assert not chosen.replaced.any()
