"""Comparison of models: probabilities of rival explanations, detection, adequacy."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import effects
from flexros.gap.candidates.candidate import Candidate, FreeParameter
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.search.model_probability import (
    RANKING,
    Contrast,
    ModelComparison,
    compare,
    contrast_of,
    form_error,
)
from flexros.record.premises import MEASURED, SIMULATED, Premises
from tests.gap.diagnosis_logs import candidates_of, predictor_of

pytestmark = pytest.mark.slow

N = 20_000
COULOMB, STRIBECK, STIFFNESS = (
    "coulomb_friction@motor_1", "stribeck_friction@motor_1", "stiffness_error@body_2.rz",
)  # fmt: skip
GAIN, INERTIA = "torque_gain_error@motor_1", "motor_inertia_error@motor_1"


def fitted(level: float, *names: str) -> CandidateFit:
    """A fit that leaves a mean squared weighted error."""
    hypothesis = tuple(candidates_of()[name] for name in names)
    predictor = predictor_of(*hypothesis)
    return CandidateFit(predictor, np.zeros(predictor.n_fitted), level * N)


def harmonic(level: float, name: str) -> CandidateFit:
    """A fit of a harmonic of the rotor."""
    sizes = {"amplitude": 1e-3, "order": 6.0, "phase": 0.5}
    free = tuple(FreeParameter(key, 1e-9, 10.0, key == "phase", (size,)) for key, size in sizes.items())
    predictor = predictor_of(Candidate(effects()[name], "motor_1", free))
    return CandidateFit(predictor, np.zeros(predictor.n_fitted), level * N)


def comparison(null: float, *fits: CandidateFit, floor_error: float = 0.0) -> ModelComparison:
    return ModelComparison(fitted(null), fits, N, floor_error)


def test_probabilities_add_up_and_follow_the_sums_of_squares() -> None:
    fits = [fitted(1.0, COULOMB), fitted(1.002, STIFFNESS), fitted(1.4, "delay@all")]
    found = comparison(2.0, *fits)
    probabilities = found.probabilities([found.null, *fits])
    assert probabilities.sum() == pytest.approx(1.0)
    assert probabilities[1] > probabilities[2] > probabilities[3]
    assert probabilities[0] < 1e-6


def test_ranked_are_the_probable_ones_first() -> None:
    fits = [fitted(1.4, "delay@all"), fitted(1.0, COULOMB), fitted(1.002, STIFFNESS)]
    found = comparison(2.0, *fits)
    assert found.ranked(fits) == [fits[1], fits[2], fits[0]]


def test_equal_explanations_share_the_probability_and_more_parameters_cost() -> None:
    one, same, richer = fitted(1.0, COULOMB), fitted(1.0, STIFFNESS), fitted(1.0, STRIBECK)
    found = comparison(2.0, one, same, richer)
    probabilities = found.probabilities([one, same, richer])
    assert probabilities[0] == pytest.approx(probabilities[1])
    assert probabilities[2] < 0.2 * probabilities[0]


def test_a_strong_gap_does_not_decide_by_a_trifle() -> None:
    """The same difference that decides a small gap may be a model-form error of a large one."""
    one, other = fitted(1.0, COULOMB), fitted(1.01, "hysteresis@motor_1")

    def of_other(null: float) -> float:
        return float(comparison(null, one, other).probabilities([one, other])[1])

    assert of_other(1e4) > 100 * of_other(1.1)


def test_of_plain_effects_that_do_nearly_the_same_what_parts_them_decides() -> None:
    """Eight nats are lost in the model-form errors of a large gap, unless predictions hardly differ by more."""
    delay, lag = fitted(1.0, "delay@all"), fitted(1.0 + 16 / N, "actuator_lag@motor_1")
    blurred = comparison(21.0, delay, lag)
    known = replace(blurred, distance=lambda *_: 16.0)
    assert blurred.probabilities([delay, lag])[0] < 0.6
    assert known.probabilities([delay, lag])[0] > 0.8
    far = replace(blurred, distance=lambda *_: 1e6)
    assert far.probabilities([delay, lag]) == pytest.approx(blurred.probabilities([delay, lag]))


def test_a_difference_beyond_what_parts_two_predictions_is_no_evidence() -> None:
    """Noise moves levels of predictions at a distance of 0.3 by 0.6: three units are a form error along the line."""
    delay, lag = fitted(1.025, "delay@all"), fitted(1.025 + 3 / N, "actuator_lag@motor_1")
    near = replace(comparison(21.0, delay, lag), distance=lambda *_: 0.1)
    assert 0.5 < near.probabilities([delay, lag])[0] < 0.62
    worse = fitted(1.025 + 40 / N, "actuator_lag@motor_1")
    near = replace(comparison(21.0, delay, worse), distance=lambda *_: 0.1)
    assert 0.5 < near.probabilities([delay, worse])[0] < 0.62
    apart = replace(near, distance=lambda *_: 40.0)
    assert apart.probabilities([delay, worse])[0] > 0.9


@pytest.mark.parametrize(("other", "decided"), [(INERTIA, False), ("delay@all", True)])
def test_a_gain_and_an_inertia_are_not_told_apart_by_what_differs_between_parts_of_a_log(
    other: str, decided: bool
) -> None:
    """A gain of 0.85 and a payload error of 25 % left 5017 and 4994 of 24,000, by 15 of chance."""
    first, second = fitted(1.0, GAIN), fitted(1.0 + 30 / N, other)
    found = replace(comparison(1.5, first, second), distance=lambda *_: 1e6, chance=lambda *_: 15.0)
    assert bool(found.probabilities([first, second])[1] < 0.01) is decided


@pytest.mark.parametrize(
    ("premises", "command", "known"), [(MEASURED, None, True), (MEASURED, 1, False), (SIMULATED, None, False)]
)
def test_only_in_measured_logs_of_torques_parts_of_a_log_tell_what_is_chance(
    premises: Premises, command: object, known: bool
) -> None:
    data: Any = SimpleNamespace(
        record=SimpleNamespace(premises=premises, command=command),
        measurement=SimpleNamespace(rounding=np.zeros(1)),
        values_of_motors=np.array([N]),
        n_values=N,
        floor_error=0.0,
        noise_level=0.0,
    )
    assert (compare(data, fitted(1.0), chance=lambda *_: 15.0).chance is not None) is known


def test_of_two_harmonics_of_a_rotor_what_parts_them_decides() -> None:
    """What a transmission error has of other orders, a ripple in its place would have as well."""
    error, ripple = (harmonic(level, name) for level, name in ((1.0, "transmission_error"), (1.01, "torque_ripple")))
    blurred = comparison(51.0, error, ripple)
    known = replace(blurred, distance=lambda *_: 200.0)
    assert blurred.probabilities([error, ripple])[0] < 0.6
    assert known.probabilities([error, ripple])[0] > 0.9
    other = comparison(51.0, error, fitted(1.01, COULOMB))
    friction = replace(other, distance=lambda *_: 200.0).probabilities([error, other.fits[1]])
    assert friction[0] < 0.6


def test_of_two_dry_frictions_of_one_level_what_parts_them_decides() -> None:
    """How dry friction sticks is no doubt about whether its level follows the load."""
    share = FreeParameter("share", 1e-6, 1.0, False, (0.01,))
    predictor = predictor_of(Candidate(effects()["load_dependent_friction"], "motor_1", (share,)))
    load = CandidateFit(predictor, np.zeros(predictor.n_fitted), 1.01 * N)
    coulomb = fitted(1.0, COULOMB)
    blurred = comparison(51.0, coulomb, load)
    known = replace(blurred, distance=lambda *_: 200.0)
    assert blurred.probabilities([coulomb, load])[0] < 0.6
    assert known.probabilities([coulomb, load])[0] > 0.9


def test_the_distance_is_asked_for_only_where_it_decides() -> None:
    def distance(*_: CandidateFit) -> float:
        raise AssertionError("two predictions for nothing")

    same, far = fitted(1.0 + 0.1 / N, "actuator_lag@motor_1"), fitted(2.0, "actuator_lag@motor_1")
    shaped, both = fitted(1.0 + 16 / N, COULOMB), fitted(1.0 - 16 / N, "delay@all", STIFFNESS)
    delay = fitted(1.0, "delay@all")
    for other in (same, far, shaped, both):
        found = replace(comparison(101.0, delay, other), distance=distance)
        assert found.probabilities([delay, other]).sum() == pytest.approx(1.0)


def test_model_form_errors() -> None:
    """Shares of the gap; along the line between two predictions 0.6 of half its length."""
    assert form_error(1e6, plain=True) == pytest.approx(200.0)
    assert form_error(1e6, plain=False) == pytest.approx(2000.0)
    assert form_error(1e6, plain=True, distance=100.0) == pytest.approx(0.18 * 100 + 4.0)
    assert form_error(1e6, plain=True, distance=1e6) == pytest.approx(200.0)


@pytest.mark.parametrize(
    ("one", "other", "own", "plain", "between"),
    [
        (("delay@all",), ("actuator_lag@motor_1",), {"delay@all"}, True, True),
        ((STIFFNESS, "delay@all"), (STIFFNESS, "actuator_lag@motor_1"), {"delay@all"}, True, True),
        (("delay@all",), (COULOMB,), {"delay@all"}, True, False),
        ((COULOMB,), ("delay@all",), {COULOMB}, False, False),
        ((COULOMB, "delay@all"), (COULOMB,), {"delay@all"}, True, False),  # an addition: there is nothing between
        ((COULOMB,), (COULOMB, "delay@all"), set(), True, False),
        ((GAIN,), (INERTIA,), {GAIN}, True, True),
    ],
)
def test_contrast_of_two_explanations(
    one: tuple[str, ...], other: tuple[str, ...], own: set[str], plain: bool, between: bool
) -> None:
    candidates = candidates_of()
    found = contrast_of(*(tuple(candidates[name] for name in names) for names in (one, other)))
    assert found == Contrast(frozenset(own), plain, between, one_scale=GAIN in own)


@pytest.mark.parametrize("swap", [False, True])
def test_an_addition_counts_by_what_it_closes_itself(swap: bool) -> None:
    """Whatever is looked at first, and however much larger the gap is that the other effect closes."""
    friction, both = fitted(1.1, COULOMB), fitted(1.0, COULOMB, STIFFNESS)
    among = [both, friction][:: -1 if swap else 1]
    assert comparison(101.0, *among).probabilities(among)[1 if swap else 0] > 0.999
    trifle = [fitted(1.1 - 2 / N, COULOMB, STIFFNESS), friction]
    assert comparison(101.0, *trifle).probabilities(trifle)[0] < 0.2


def test_what_an_effect_closes_is_bounded_by_the_best_fit_without_it() -> None:
    """The others were never fitted alone, but a part of them leaves little already, however large the whole gap is."""
    rich, simple = fitted(1.0, STRIBECK, STIFFNESS), fitted(1.1, COULOMB, STIFFNESS)
    assert comparison(1e4, rich, simple).probabilities([rich, simple])[0] < 0.7
    among = comparison(1e4, rich, simple, fitted(2.0, STIFFNESS))
    assert among.probabilities([rich, simple])[0] > 0.99


def test_of_odds_that_go_round_in_a_circle_the_least_lost_counts() -> None:
    """A rich law loses to a plain number within its form error, and that to an explanation which the first refutes."""
    base, friction, late = "extra_mode@base", "presliding_friction@motor_1", "delay@all"
    rich, plain = fitted(1.0, base, friction), fitted(1.0 + 3 / N, STIFFNESS, friction)
    refuted = fitted(1.005, base, late)
    among = [rich, plain, refuted]
    found = comparison(51.0, *among, fitted(1.01, base))
    assert found.probabilities([plain, refuted])[1] > 0.5
    assert found.probabilities([refuted, rich])[1] > 0.999
    probabilities = found.probabilities(among)
    assert probabilities[1] > 0.8
    assert probabilities[2] < 1e-6
    assert found.ranked(among)[0] is plain


def test_parameters_of_a_law_cost_less_where_model_form_errors_count_more_than_noise() -> None:
    one, richer = fitted(1.0, COULOMB), fitted(1.0, "presliding_friction@motor_1")

    def of_richer(null: float) -> float:
        return float(comparison(null, one, richer).probabilities([one, richer])[1])

    assert of_richer(1.01) == pytest.approx(np.exp(-3 * 5), rel=1e-3)
    assert of_richer(1e4) == pytest.approx(np.exp(-5), rel=1e-1)


def test_nothing_wins_where_nothing_gains_more_than_chance() -> None:
    fits = [fitted(1.0 - 2.0 / N, COULOMB), fitted(1.0 - 4.0 / N, STRIBECK)]
    found = comparison(1.0, *fits)
    assert not found.detected
    assert found.probabilities([found.null, *fits])[0] > 0.5


def test_an_effect_that_is_worth_its_parameters_is_detected() -> None:
    assert comparison(1.0, fitted(1.0 - 40.0 / N, COULOMB)).detected


def test_rounding_at_one_encoder_feigns_nothing_at_the_others() -> None:
    """It hid a gain of torques that was worth 150, at another motor of six."""
    data: Any = SimpleNamespace(
        record=SimpleNamespace(premises=SIMULATED, command=None),
        measurement=SimpleNamespace(rounding=np.array([0.0, 0.0, 0.9])),
        values_of_motors=np.full(3, 1000),
        n_values=N,
        floor_error=0.0,
        noise_level=0.0,
    )
    found = compare(data, fitted(100.0))
    assert found.threshold == pytest.approx(RANKING.detected + RANKING.rounded * 0.9 * 1000)


def test_gain_is_twice_the_gain_in_likelihood_less_the_information_criterion() -> None:
    one = fitted(1.0, STRIBECK)
    found = comparison(1.2, one)
    assert found.gain(one) == pytest.approx(N * np.log(1.2))
    assert found.penalty(one) == pytest.approx(3 * np.log(N))
    assert found.score(one) == pytest.approx(found.gain(one) - found.penalty(one))


@pytest.mark.filterwarnings("error")
def test_a_fit_that_diverged_gains_nothing() -> None:
    assert comparison(1.2, fitted(np.inf, STRIBECK)).gain(fitted(np.inf, STRIBECK)) == -np.inf


def test_noise_that_a_fit_refutes_hides_nothing() -> None:
    """An encoder of an arm that shakes seems noisier than it is."""
    for least, levels in ((0.8, (0.8,)), (0.5, (0.8, 0.0))):
        found = replace(comparison(2.0, fitted(least, COULOMB)), noise_level=0.8)
        assert found.levels_of_noise == levels
    assert found.beyond_noise(0.9) == pytest.approx(0.5)
    assert found.beyond_noise(0.9, 0.0) == pytest.approx(0.9)


def test_what_noise_leaves_is_not_significant() -> None:
    exact = np.sqrt(2 / N)
    assert not comparison(1.0).significant(fitted(1 + 2 * exact, COULOMB))
    assert comparison(1.0).significant(fitted(1 + 8 * exact, COULOMB))
    assert not comparison(1.0, floor_error=0.1).significant(fitted(1 + 8 * exact, COULOMB))


def test_shares_of_the_gap() -> None:
    half, closed = fitted(6.0, COULOMB), fitted(1.0, COULOMB, STIFFNESS)
    found = comparison(11.0, half, closed)
    assert found.remainder(half) == pytest.approx(0.5)
    assert found.remainder(closed) == 0.0
    assert found.removed(half, closed) == pytest.approx(1.0)
    assert found.removed(found.null, half) == pytest.approx(0.5)


def test_with_an_exact_model_only_model_form_errors_excuse_what_is_left() -> None:
    poor, fair, small = fitted(60.0, COULOMB), fitted(10.0, COULOMB), fitted(1.9, COULOMB)
    toleranced = comparison(1001.0)
    exact = replace(toleranced, exact=True)
    assert [toleranced.adequate(one) for one in (poor, fair, small)] == [True, True, True]
    assert [exact.adequate(one) for one in (poor, fair, small)] == [False, True, True]
    assert replace(comparison(11.0), exact=True).adequate(small)  # no more than the noise
    assert exact.adequate(fitted(30.0, COULOMB), elsewhere=True)
    assert not exact.adequate(fitted(30.0, COULOMB))
    assert not comparison(501.0).adequate(poor)


def test_what_leaves_too_much_is_behind_what_does_not_though_it_has_fewer_parameters() -> None:
    poor = fitted(45.0, COULOMB)
    rich = fitted(1.0, "presliding_friction@motor_1", STIFFNESS, "delay@all", "payload_error@tool")
    found = comparison(2001.0, poor, rich)
    assert found.probabilities([poor, rich])[0] > 0.9
    assert replace(found, exact=True).probabilities([poor, rich])[1] > 0.9
    worst = fitted(70.0, COULOMB, STIFFNESS)
    left_alone = replace(found, exact=True).probabilities([poor, worst])
    assert left_alone == pytest.approx(found.probabilities([poor, worst]))


def test_parameters_of_the_model_are_plain_and_laws_are_not() -> None:
    def one(name: str) -> Candidate:
        return candidates_of()[name]

    assert all(one(name).effect.plain for name in (STIFFNESS, "motor_inertia_error@motor_1", "payload_error@tool"))
    assert not any(one(name).effect.plain for name in (COULOMB, "backlash@motor_1", "extra_mode@tool"))


def test_deviations_are_beyond_tolerance_where_chance_does_not_make_as_many() -> None:
    names = ("body_1.rz.stiffness", "body_2.rz.stiffness", "body_3.rz.stiffness")
    predictor = predictor_of(tolerance=Tolerance(names, (0.03, 0.03, 0.03)))
    near, far = (CandidateFit(predictor, np.array(theta), 1.0 * N) for theta in ([1.0, -2.0, 1.5], [0.5, 4.5, 0.0]))
    assert near.prior_penalty == pytest.approx(7.25)
    assert not comparison(1.0).beyond_tolerance(near)
    assert comparison(1.0).beyond_tolerance(far)
    assert not comparison(1.0).beyond_tolerance(fitted(1.0))
