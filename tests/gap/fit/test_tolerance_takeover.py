"""Candidates in place of deviations beyond tolerance."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.fit.tolerance_takeover import takeover, with_own_numbers, with_takeover
from tests.gap.diagnosis_logs import ROBOT, candidates_of, data_of, encoded, predictor_of

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


@pytest.mark.slow
@pytest.mark.parametrize(("name", "number", "size"), [
    (STIFFNESS, "body_2.rz.stiffness", {"relative": 0.2}),
    ("viscous_friction@motor_1", "motor_1.viscous_friction", {"coefficient": 0.05, "asymmetry": 0.1}),
])  # fmt: skip
def test_a_number_far_out_is_part_of_the_effect_that_is_an_error_of_it(
    name: str, number: str, size: dict[str, float]
) -> None:
    """An inertia error of +425 % had stood beside the same inertia by -39 %."""
    (key, value), data = next(iter(size.items())), data_of()
    candidate = candidates_of()[name]
    predictor = predictor_of(candidate, tolerance=Tolerance((number,), (0.1,)))
    others = encoded(candidate, **size)
    theta = np.array([*others, -5.0])
    fit = CandidateFit(predictor, theta, float(chi2_of(predictor, data, theta[:, None])[0]))
    whole = with_own_numbers(fit, data, 4.0)
    assert whole.deviations.tolist() == [0.0]
    change = np.expm1(-0.5) * (1.0 if key == "relative" else ROBOT.parameters[number].value)
    assert predictor.values(whole.theta)[0][key] == pytest.approx(value + change)
    assert fit.chi2 - whole.chi2 == pytest.approx(25 * data.misfit, rel=1e-3)  # the same predictions
    assert with_own_numbers(fit, data, 6.0) is fit
