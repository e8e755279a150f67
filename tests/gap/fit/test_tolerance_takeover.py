"""Candidates in place of deviations beyond tolerance."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.fit.tolerance_takeover import takeover, with_own_numbers, with_takeover
from tests.gap.diagnosis_logs import ROBOT, candidates_of, data_of, encoded, predictor_of, search_of

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


def test_friction_takes_over_what_its_number_deviates_by_along_directions_of_many() -> None:
    """Viscous friction of -1.96 and a tolerated number of +2.00 Nm s/rad cancelled in a patch, and one was a cause."""
    number, data = "motor_1.viscous_friction", data_of()
    candidate = candidates_of()["viscous_friction@motor_1"]
    directions = np.array([[0.6, 0.8], [0.8, -0.6]])
    tolerance = Tolerance((number, "body_1.rz.stiffness"), (0.1, 0.02), directions=directions)
    predictor = predictor_of(candidate, tolerance=tolerance)
    theta = np.array([*encoded(candidate, coefficient=0.05, asymmetry=0.1), 2.0, 1.0])
    fit = CandidateFit(predictor, theta, float(chi2_of(predictor, data, theta[:, None])[0]))
    whole = with_own_numbers(fit, data, 4.0)
    assert whole.predictor.tolerance.deviations == (0.0, 0.02)
    added = np.expm1(0.1 * (0.6 * 2.0 + 0.8)) * ROBOT.parameters[number].value
    assert predictor.values(whole.theta)[0]["coefficient"] == pytest.approx(0.05 + added)
    assert whole.chi2 == pytest.approx(fit.chi2, rel=1e-6)
    assert whole.information.shape == (4, 4)
    assert with_own_numbers(whole, data, 4.0) is whole


def test_no_more_than_the_nominal_friction_is_taken_away() -> None:
    """Beside a number that is too small as well, a fit takes more away than there is; a patch cannot."""
    number, data = "motor_1.viscous_friction", data_of()
    every = list_candidates(ROBOT, search_of().scales, measured=True)
    (candidate,) = (one for one in every if one.name == "viscous_friction@motor_1")
    tolerance = Tolerance((number,), (0.1,), directions=np.eye(1))
    nominal = ROBOT.parameters[number].value
    theta = np.array([*encoded(candidate, coefficient=-nominal, asymmetry=0.1), -2.0])
    whole = with_own_numbers(CandidateFit(predictor_of(candidate, tolerance=tolerance), theta, 1e4), data, 4.0)
    assert whole.predictor.values(whole.theta)[0]["coefficient"] == pytest.approx(-nominal)
    assert whole.theta[0] == whole.predictor.bounds[0][0]
