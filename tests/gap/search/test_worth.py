"""What effects must achieve on a real machine, and simple effects before rich ones."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flexros.effects import effects
from flexros.effects.base_tilt import BaseTilt
from flexros.effects.torque_bias import TorqueBias
from flexros.gap.search.model_probability import ModelComparison
from flexros.gap.search.worth import (
    floor_is_uncertain,
    gap_of_laws,
    in_vain,
    incomplete,
    more_than_before,
    simple_first,
    simplest,
    worth,
)
from flexros.gap.settings import DiagnosisSettings
from flexros.record.premises import MEASURED, SIMULATED
from tests.gap.diagnosis_logs import candidates_of

if TYPE_CHECKING:
    from collections.abc import Sequence

COULOMB, PRESLIDING = "coulomb_friction@motor_1", "presliding_friction@motor_1"
INERTIA = "motor_inertia_error@motor_1"


@pytest.mark.parametrize(("before", "after", "expected"), [(20.0, 19.0, False), (20.0, 15.0, True), (2.5, 2.1, True)])
def test_an_effect_of_a_real_machine_removes_a_good_part_of_what_is_above_the_floor(
    before: float, after: float, expected: bool
) -> None:
    comparison, (rest, fit) = measured_fits(before, after)
    assert worth(measured_search(), comparison, rest, fit, 0.4) is expected


def test_an_effect_without_which_the_prediction_diverges_is_worth_it() -> None:
    """Nine of ten effects were left out, as the sum of squares without two of them was infinite."""
    comparison, (rest, fit) = measured_fits(np.inf, 0.3)
    assert worth(measured_search(), comparison, rest, fit, 0.2)
    assert not worth(measured_search(), comparison, rest, rest, 0.2)


@pytest.mark.parametrize(("before", "after", "expected"), [
    (0.95, 0.8, False), (0.95, 0.1, True), (0.4, 0.08, True), (1.1, 0.82, False), (1.9, 1.5, False), (1.9, 0.7, True),
])  # fmt: skip
def test_within_what_an_explanation_of_a_real_machine_may_leave_only_much_of_it_is_found(
    before: float, after: float, expected: bool
) -> None:
    """Torques may be known better than stated, as in the log of a simulator."""
    comparison, (rest, fit) = measured_fits(before, after)
    search = measured_search()
    assert incomplete(search, comparison, rest)
    assert worth(search, comparison, rest, fit, 0.4) is expected


@pytest.mark.parametrize(("before", "after", "expected"), [
    (0.95, 0.84, True), (0.95, 0.88, False), (0.83, 0.805, True), (0.807, 0.801, False), (0.79, 0.7, False),
])  # fmt: skip
def test_within_the_floor_noise_of_encoders_counts_for_nothing(before: float, after: float, expected: bool) -> None:
    """Four fifths of the floor are noise that no effect removes; far less than the tolerance is within it."""
    comparison, (rest, fit) = measured_fits(before, after)
    assert worth(measured_search(), replace(comparison, noise_level=0.8), rest, fit, 0.4) is expected


@pytest.mark.parametrize(("motors", "before", "after", "expected"), [
    (6, 1.9, 1.6, True), (6, 1.9, 1.75, False), (1, 1.9, 1.6, False), (2, 1.9, 1.3, True), (6, 1.95, 1.78, False),
])  # fmt: skip
def test_an_effect_beyond_the_tolerance_of_one_of_many_motors_is_found_within_two_floors_of_all(
    motors: int, before: float, after: float, expected: bool
) -> None:
    """A ripple of a sixth of the rms torque of one of six motors left two floors of all six without it."""
    assert is_worth([before] * motors, [after] * motors) is expected


@pytest.mark.parametrize(("first", "second", "expected"), [
    ((3.4, 0.4, 0.4, 0.4, 0.4, 0.4), (1.6, 0.4, 0.4, 0.4, 0.4, 0.4), True),  # beyond the tolerance of its motor
    ((0.9, 0.9, 0.9, 0.9, 0.9, 0.9), (0.6, 0.6, 0.6, 0.6, 0.6, 0.6), False),  # a little at each, within it
    ((3.9, 0.4, 0.4, 0.4, 0.4, 0.4), (3.0, 0.4, 0.4, 0.3, 0.3, 0.3), False),
    ((11.4, 0.1, 0.1, 0.1, 0.1, 0.1), (10.3, 0.1, 0.1, 0.1, 0.1, 0.1), False),  # less than a fifth of what is above it
])  # fmt: skip
def test_an_effect_beyond_the_tolerance_of_one_motor_is_found_within_the_floor_of_all(
    first: Sequence[float], second: Sequence[float], expected: bool
) -> None:
    """Cogging of two of six motors was excused by four motors whose torques were known well."""
    assert is_worth(first, second) is expected


def test_what_a_curve_lacks_beside_noise_is_no_effect() -> None:
    comparison, (rest, fit) = measured_fits(0.95, 0.82)
    comparison = replace(comparison, noise_level=0.8)
    assert worth(measured_search(), comparison, rest, fit, 0.4)
    rest.hypothesis = (SimpleNamespace(effect=effects()["spring_curve"]),)
    assert not worth(measured_search(), comparison, rest, fit, 0.4)


@pytest.mark.parametrize(("floor_error", "rounding", "level", "expected"), [
    (0.1, 0.9, 0.98, True),
    (0.1, 0.0, 0.98, False),
    (0.1, 0.0, 1.05, True),
    (0.1, 0.0, 1.0005, False),
    (0.001, 0.9, 1.0005, False),
])  # fmt: skip
def test_where_the_floor_is_uncertain_effects_may_be_missing_near_it(
    floor_error: float, rounding: float, level: float, expected: bool
) -> None:
    """Of a floor known to 10 %, a level of 1.05 does not tell whether an effect is missing that gains 500 nats."""
    comparison, (_, fit) = measured_fits(50.0, level)
    comparison = replace(comparison, floor_error=floor_error, rounding=rounding)
    search: Any = SimpleNamespace(premises=SIMULATED)
    assert incomplete(search, comparison, fit) is expected


@pytest.mark.parametrize(("floor_error", "expected"), [(0.03, True), (0.005, False), (0.0, False)])
def test_a_floor_is_uncertain_that_is_known_worse_than_by_chance(floor_error: float, expected: bool) -> None:
    """Coloured noise left a doubt of 3 %, in which friction of 3000 nats was not looked for."""
    comparison = replace(measured_fits(50.0, 0.98)[0], floor_error=floor_error)  # by chance 0.01
    assert floor_is_uncertain(comparison) is expected


def test_an_effect_that_brings_numbers_of_the_model_back_into_tolerance_is_worth_it() -> None:
    """However little it removes: the numbers had taken over what it does in this log, not in others."""
    comparison, fits = measured_fits(0.94, 0.77, 0.77)
    for fit, penalty in zip(fits, (146.0, 5.0, 120.0)):
        fit.prior_penalty, fit.predictor.tolerance.n_free = penalty, 18
    assert worth(measured_search(), comparison, fits[0], fits[1], 0.4)
    assert not worth(measured_search(), comparison, fits[0], fits[2], 0.4)


@pytest.mark.parametrize(("far", "level", "expected"), [(5.2, 0.84, True), (3.0, 0.84, False), (5.2, 3.0, False)])
def test_the_error_of_one_number_far_out_of_tolerance_is_worth_it_beside_many_within(
    far: float, level: float, expected: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A spring that was a third too soft was named, and left out again as all numbers together were within."""
    monkeypatch.setattr("flexros.gap.search.worth.takeover", lambda _one, _rest: SimpleNamespace(gain=far**2))
    comparison, (rest, fit) = measured_fits(level, 0.99 * level)
    fit = measured_fit(0.99 * level, INERTIA)
    for one, penalty in ((rest, 51.0), (fit, 51.0 - far**2)):
        one.prior_penalty, one.names = penalty, {candidate.name for candidate in one.hypothesis}
        one.predictor = SimpleNamespace(n_effect=1, tolerance=SimpleNamespace(n_free=40))
    assert worth(measured_search(), comparison, rest, fit, 0.4) is expected


@pytest.mark.parametrize(("name", "expected"), [(INERTIA, True), (COULOMB, False)])
def test_the_gap_of_a_wrong_number_hides_no_effect_in_a_simulated_log(name: str, expected: bool) -> None:
    """A load that was half of the true one made a gap of 2e6, beside which five effects seemed to be errors of form."""
    comparison, (rest, fit) = measured_fits(2e6, 1.2, 1.1)[0], [measured_fit(level, name) for level in (1.2, 1.1)]
    search = measured_search()
    search.premises = SIMULATED
    search.level_without = lambda _fit, names: 2e6 if names else 30.0
    assert worth(search, comparison, rest, fit, 0.4) is expected
    assert gap_of_laws(search, comparison, fit) == (29.0 if expected else 2e6 - 1)


@pytest.mark.parametrize(("before", "level", "expected"), [
    (0.89, 1.05, True), (0.89, 0.94, False), (1.05, 1.05, False), (None, 9.0, False),
])  # fmt: skip
def test_noise_leaves_as_much_in_a_looser_tie(before: float | None, level: float, expected: bool) -> None:
    """Beside a doubt of 12 % about the noise, a limit of torques and an encoder's offset imitated errors of form."""
    comparison, (_, fit) = measured_fits(50.0, level)
    search: Any = SimpleNamespace(left_before=before)
    assert more_than_before(search, replace(comparison, floor_error=0.03), fit) is expected


@pytest.mark.parametrize(("left", "expected"), [(0.5, True), (0.75, False)])
def test_a_slant_of_the_base_is_worth_it_where_torques_show_it(left: float, expected: bool) -> None:
    """Each motor counts as much: a slant removed a fifth of all errors, most of which were of other motors."""
    comparison, (before, after) = measured_fits(2.55, 2.45)
    slant = SimpleNamespace(name="base_tilt@base", effect=BaseTilt, free=("x", "y"))
    after.hypothesis = (slant,)
    for one, names, errors in ((before, (), 1.0), (after, ("base_tilt@base",), left)):
        one.names = frozenset(names)
        one.residual = lambda _, errors=errors: np.array([9.0, 9.0, 1.0, errors, 0.02 * errors])
    search = measured_search()
    search.data.torques = SimpleNamespace(size=3)
    search.null = SimpleNamespace(model=SimpleNamespace(robot=SimpleNamespace(n_motors=3)))
    assert worth(search, comparison, before, after, 0.4) is expected
    after.hypothesis = (SimpleNamespace(name="torque_bias@motor_2", effect=TorqueBias, free=("torque",)),)
    after.names = frozenset(["torque_bias@motor_2"])
    assert not worth(search, comparison, before, after, 0.4)


def measured_fits(*levels: float) -> tuple[ModelComparison, list[Any]]:
    """Fits of a log of 20,000 values that leave these mean squared errors, without tolerances."""
    predictor = SimpleNamespace(n_effect=1, tolerance=SimpleNamespace(n_free=0))
    fits: list[Any] = [
        SimpleNamespace(chi2=20_000 * level, predictor=predictor, prior_penalty=0.0, hypothesis=()) for level in levels
    ]
    return ModelComparison(fits[0], tuple(fits[1:]), 20_000), fits


def measured_search() -> Any:
    """Search in a measured log."""
    data = SimpleNamespace(record=SimpleNamespace(position=np.zeros((10, 1))), torques=None)
    return SimpleNamespace(settings=DiagnosisSettings(), data=data, premises=MEASURED)


def is_worth(before: Sequence[float], after: Sequence[float]) -> bool:
    """Return whether an effect is worth it after which this is left at the motors."""
    n, motors = 1_000, len(before)
    comparison, (rest, fit) = measured_fits(float(np.mean(before)), float(np.mean(after)))
    for one, levels, name in ((rest, before, ""), (fit, after, "ripple")):
        one.names = frozenset([name])
        one.residual = lambda _, levels=levels: np.repeat(np.sqrt(np.array(levels)), n)
    search = measured_search()
    search.data.record.position, search.data.values_of_motors = np.zeros((n, motors)), np.full(motors, n)
    return worth(search, comparison, rest, fit, 0.4)


def measured_fit(level: float, *names: str) -> Any:
    """Fit of these candidates to a measured log."""
    hypothesis = tuple(candidates_of()[name] for name in names)
    predictor = SimpleNamespace(n_effect=len(hypothesis), tolerance=SimpleNamespace(n_free=0))
    return SimpleNamespace(
        chi2=20_000 * level, predictor=predictor, prior_penalty=0.0, hypothesis=hypothesis, names=frozenset(names)
    )


@pytest.mark.parametrize(("gain", "kept"), [(75.0, [COULOMB]), (50.0, [PRESLIDING, COULOMB])])
def test_a_simple_effect_that_does_nearly_as_much_comes_first(gain: float, kept: list[str]) -> None:
    additions: list[Any] = [
        SimpleNamespace(candidate=candidates_of()[name], gain=size)
        for name, size in ((PRESLIDING, 100.0), (COULOMB, gain))
    ]
    left = simple_first(measured_search(), measured_fit(5.0), additions)
    assert [one.candidate.name for one in left] == kept


def test_a_rich_effect_is_not_added_to_a_simple_one_that_it_extends() -> None:
    rich: Any = SimpleNamespace(candidate=candidates_of()[PRESLIDING], gain=100.0)
    assert not simple_first(measured_search(), measured_fit(5.0, COULOMB), [rich])


@pytest.mark.parametrize(("level", "chosen"), [(4.9, COULOMB), (2.0, PRESLIDING)])
def test_a_rich_effect_stays_where_it_does_much_more(level: float, chosen: str) -> None:
    null, simple, rich = measured_fit(20.0), measured_fit(5.0, COULOMB), measured_fit(level, PRESLIDING)
    comparison = ModelComparison(null, (simple, rich), 20_000)
    assert simplest(measured_search(), comparison, rich, [simple, rich]).names == {chosen}


def test_what_is_within_the_numerical_error_of_a_model_is_no_effect() -> None:
    null, rest, fit = measured_fit(1e8), measured_fit(1.9, COULOMB), measured_fit(1.0, COULOMB, PRESLIDING)
    search = measured_search()
    search.premises = SIMULATED
    assert not worth(search, ModelComparison(null, (rest, fit), 20_000), rest, fit, 0.4)
    assert worth(search, ModelComparison(measured_fit(1e3), (rest, fit), 20_000), rest, fit, 0.4)


@pytest.mark.parametrize(("quiet", "expected"), [(2_000.0, True), (6_000.0, False)])
def test_most_of_what_remains_at_one_of_several_motors_is_worth_it(quiet: float, expected: bool) -> None:
    """An unknown effect at the first motor leaves 400,000; beside it, one at the second removes little of the whole."""
    n = 1_000
    null, rest, fit = measured_fit(1e3), measured_fit(20.5), measured_fit(20.0, COULOMB)
    for one, sums in ((rest, (400_000.0, 11_000.0)), (fit, (400_000.0, quiet))):
        one.residual = lambda _, sums=sums: np.repeat(np.sqrt(np.array(sums) / n), n)
    record = SimpleNamespace(position=np.zeros((n, 2)))
    data = SimpleNamespace(record=record, values_of_motors=np.array([n, n]))
    search: Any = SimpleNamespace(settings=DiagnosisSettings(), data=data, premises=SIMULATED)
    assert worth(search, ModelComparison(null, (rest, fit), 20_000), rest, fit, 0.4) is expected


@pytest.mark.parametrize(
    ("constant", "level", "expected"), [(12.0, 300.0, True), (8.0, 300.0, False), (12.0, 1.3, False)]
)
def test_an_effect_of_constant_size_stays_beside_what_no_effect_explains(
    monkeypatch: pytest.MonkeyPatch, constant: float, level: float, expected: bool
) -> None:
    """It removes a fifth of what is left. Where the explanation suffices, an error of form may be constant too."""
    monkeypatch.setattr("flexros.gap.search.worth.constancies", lambda fit, *_: dict.fromkeys(fit.names, constant))
    rest, fit = measured_fit(1 + 1.25 * (level - 1), COULOMB), measured_fit(level, COULOMB, PRESLIDING)
    search = measured_search()
    search.premises = SIMULATED
    assert worth(search, ModelComparison(measured_fit(1e3), (rest, fit), 20_000), rest, fit, 0.4) is expected


@pytest.mark.parametrize(("null", "expected"), [(2.6, True), (20.0, False)])
def test_what_is_left_of_a_small_gap_is_worth_an_effect_that_ends_it(null: float, expected: bool) -> None:
    """Within the floors of a measured log: a quarter of a small gap is left, or a fiftieth of a large one."""
    rest, fit = measured_fit(1.37, COULOMB), measured_fit(0.88, COULOMB, PRESLIDING)
    comparison = ModelComparison(measured_fit(null), (rest, fit), 20_000)
    assert worth(measured_search(), comparison, rest, fit, 0.4) is expected


@pytest.mark.parametrize(
    ("null", "before", "after", "expected"),
    [
        (1.7, 1.035, 1.029, True),
        (5.0, 1.035, 1.029, False),
        (1.7, 1.056, 1.05, False),
        (1.7, 1.03, 1.0297, False),
        (2000.0, 1.0096, 0.978, False),
        (2000.0, 1.08, 0.978, True),
    ],
)
def test_an_effect_that_leaves_noise_need_not_remove_a_share_of_it(
    null: float, before: float, after: float, expected: bool
) -> None:
    """Noise of 20,000 values is known to 0.04: 60 nats of friction were a sixth of what seemed to be left above it.

    Of a large gap they may be the form of another effect, however large a share of chance that is, and where more than
    noise is left an imitation; three nats are chance.
    """
    rest, fit = measured_fit(before, COULOMB), measured_fit(after, COULOMB, PRESLIDING)
    search = measured_search()
    search.premises = SIMULATED
    assert worth(search, ModelComparison(measured_fit(null), (rest, fit), 20_000), rest, fit, 0.4) is expected


@pytest.mark.parametrize(
    ("resumed", "left", "expected"), [(True, True, True), (True, False, False), (False, True, False)]
)
def test_only_a_resumed_search_that_leaves_more_than_noise_is_in_vain(
    monkeypatch: pytest.MonkeyPatch, resumed: bool, left: bool, expected: bool
) -> None:
    monkeypatch.setattr("flexros.gap.search.worth.compared", lambda *_: SimpleNamespace(significant=lambda _fit: left))
    monkeypatch.setattr("flexros.gap.search.worth.more_than_before", lambda *_: False)
    search: Any = SimpleNamespace(resumed=resumed)
    fit: Any = SimpleNamespace()
    assert in_vain(search, fit) is expected
