"""Elimination of the effects that torques show, and of further ones, by linear theory and by fits."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import effects
from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import scales_of_motors
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.checked_log import checked_log
from flexros.gap.deadline import Deadline
from flexros.gap.search import elimination
from flexros.gap.search.elimination import _nothing
from flexros.gap.settings import DiagnosisSettings
from flexros.record.premises import MEASURED, SIMULATED, Premises
from tests.gap.servo_logs import servo_arm, servo_log

INERTIA, STIFFNESS = "motor_inertia_error@motor_1", "stiffness_error@body_2.ry"
LEFT_OUT = "tool_load@tool"
LOAD = "load_dependent_friction@motor_1"
DRIFT, OFFSET = "friction_drift@motor_1", "encoder_offset@motor_2"
COULOMB, VISCOUS, BIAS = "coulomb_friction@motor_1", "viscous_friction@motor_1", "torque_bias@motor_2"
N = 1000


@dataclass(frozen=True)
class Fit:
    """A fit of named effects."""

    kept: tuple[str, ...]
    chi2: float
    prior_penalty: float = 0.0
    free: tuple[str, ...] = ("size",)

    @property
    def names(self) -> frozenset[str]:
        return frozenset(self.kept)

    @property
    def hypothesis(self) -> tuple[Any, ...]:
        free = tuple(SimpleNamespace(name=name, high=10.0) for name in self.free)
        parts = [(one, *one.split("@")) for one in self.kept]
        return tuple(
            SimpleNamespace(name=one, effect=effects()[effect], location=location, free=free)
            for one, effect, location in parts
        )


class Search:
    """A search whose fits and estimates are given by the effects they have.

    Args:
        chi2: Sum of squares of a fit, by its effects.
        estimated: Sum of squares without one of several effects, by linear theory.
        base: Effects that the torques show.
    """

    torques_decide = from_torques = True
    fall = 0.0

    def __init__(self, chi2: dict[frozenset[str], float], estimated: dict[str, float], base: tuple[str, ...]) -> None:
        self.chi2, self.estimated = chi2, estimated
        self.base = Fit(base, 0.0)
        self.of_torques = self.base.names
        robot = SimpleNamespace(n_coordinates=2, n_motors=2)
        tolerance = Tolerance(("motor_1.inertia",), (0.03,))
        null = SimpleNamespace(predictor=SimpleNamespace(tolerance=tolerance))
        self.null = SimpleNamespace(fit=null, model=SimpleNamespace(robot=robot))
        self.premises = MEASURED
        self.data = SimpleNamespace(n_values=N, negligible=0.0, record=SimpleNamespace(command=None))
        self.settings = DiagnosisSettings()
        self.deadline = Deadline()

    def shown_by_torques(self, fit: Fit) -> frozenset[str]:
        return self.base.names & fit.names

    def surroundings(self, fit: Fit) -> Any:
        return SimpleNamespace(least=fit.chi2, fall=self.fall)

    def removals(self, fit: Fit, surroundings: Any) -> list[Any]:
        return [SimpleNamespace(least=surroundings.least + self.estimated[name]) for name in fit.kept]

    def removals_together(self, fit: Fit, surroundings: Any, sets: list[list[str]]) -> list[Any]:
        del fit
        return [SimpleNamespace(least=surroundings.least + sum(self.estimated[name] for name in one)) for one in sets]

    def without(self, fit: Fit, *names: str) -> Fit:
        rest = tuple(name for name in fit.kept if name not in names)
        return Fit(rest, self.chi2[frozenset(rest)])

    def candidates(self) -> tuple[Any, ...]:
        return ()

    def directions(self, candidates: list[Any], fit: Fit) -> list[Any]:
        del fit
        return candidates

    def additions(self, directions: list[Any], fit: Fit, surroundings: Any) -> list[Any]:
        del fit, surroundings
        return directions

    def together(self, fit: Fit, additions: list[Any]) -> Fit:
        kept = (*fit.kept, *(one.name for one in additions))
        return Fit(kept, self.chi2[frozenset(kept)])

    def completed(self, fit: Fit) -> Fit:
        return fit

    def parallel(self, _: str, function: Any, items: list[str], *, needed: int) -> list[Any]:
        return [function(one) for one in items[:needed]]


def size_of(value: float, std: float) -> Any:
    """Size of an effect; without a deviation the log does not determine it."""
    return SimpleNamespace(value=value, std=std, determined=std > 0)


@pytest.fixture(autouse=True)
def plain_rules(monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction is clear once it is alone at its motor; an effect must remove a fifth of what is left."""

    def sizes(fit: Fit, _: Any) -> list[dict[str, Any]]:
        both = {COULOMB, VISCOUS} <= fit.names
        return [{"size": size_of(1.0, 1.0 if both else 0.1)} for _ in fit.kept]

    def worth(search: Any, comparison: Any, before: Fit, after: Fit, removed: float) -> bool:
        return before.chi2 - after.chi2 > removed * before.chi2

    monkeypatch.setattr(elimination, "parameters_of", sizes)
    monkeypatch.setattr(elimination, "worth", worth)
    monkeypatch.setattr(elimination, "best_of_each", list)
    monkeypatch.setattr(
        elimination, "compared", lambda *_: SimpleNamespace(threshold=6.0, beyond_tolerance=lambda _: False)
    )


def test_of_two_effects_that_do_much_the_same_the_better_one_stays() -> None:
    base = (COULOMB, VISCOUS, "coulomb_friction@motor_2")
    rest = frozenset({COULOMB, "coulomb_friction@motor_2"})
    search: Any = Search({rest: 2010.0}, {COULOMB: 20.0, VISCOUS: 10.0, "coulomb_friction@motor_2": 500.0}, base)
    fits: list[Any] = []
    assert elimination.reduced(search, Fit(base, 2000.0), fits, 0.2).names == rest  # type: ignore[arg-type]
    assert len(fits) == 1


def test_of_effects_at_other_places_that_seem_needless_the_least_needed_one_goes_first() -> None:
    """A lag of one motor beside a delay of all: without either, the other one is needed."""
    delay, lag = "delay@all", "actuator_lag@motor_1"
    left = {(COULOMB, delay): 2100.0, (COULOMB, lag): 2200.0, (COULOMB,): 3000.0}
    rises = {COULOMB: 900.0, delay: 200.0, lag: 100.0}
    search: Any = Search({frozenset(names): chi2 for names, chi2 in left.items()}, rises, (COULOMB,))
    search.completed = lambda fit: fit
    kept = elimination.one_by_one(search, Fit((COULOMB, delay, lag), 2000.0), [])  # type: ignore[arg-type]
    assert kept.names == {COULOMB, delay}


@pytest.mark.slow
def test_a_rotor_is_none_beside_the_inertia_of_its_bodies_and_not_beside_that_of_a_large_arm() -> None:
    """The search for rotors goes up to 10 kg m2, of which a thousandth is a rotor at a wrist."""
    robot = servo_arm(rotors=False)
    data = SimpleNamespace(record=checked_log(servo_log(robot=servo_arm), robot, name="log"))
    candidates = list_candidates(robot, scales_of_motors(robot, data.record), measured=True)
    rotor = next(one for one in candidates if one.name == "rotor_inertia@motor_2")
    null = SimpleNamespace(model=SimpleNamespace(robot=robot))
    search: Any = SimpleNamespace(data=data, null=null, settings=DiagnosisSettings())
    inertia = 0.02 * 0.3 + 0.3 * 0.1**2
    assert _nothing(search, rotor, rotor.free[0]) == pytest.approx(1e-3 * inertia)


def test_nothing_is_left_out_where_the_result_would_be_of_no_use() -> None:
    search: Any = Search({frozenset({COULOMB}): 2010.0}, {COULOMB: 900.0, VISCOUS: 10.0}, ())
    begin: Any = Fit((COULOMB, VISCOUS), 2000.0)
    assert elimination.one_by_one(search, begin, [], most=1999.0) is begin
    assert elimination.one_by_one(search, begin, [], most=2001.0).names == {COULOMB}


def test_of_unclear_effects_of_a_servo_the_least_clear_one_goes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Inertia and viscous friction have a common factor: without the one that is nearly zero, the other is clear."""

    def sizes(fit: Fit, _: Any) -> list[dict[str, Any]]:
        both = {INERTIA, VISCOUS} <= fit.names
        unclear = {INERTIA: size_of(-0.39, 0.49), VISCOUS: size_of(-0.03, 4.3)}
        return [{"size": unclear[one] if both and one in unclear else size_of(1.0, 0.1)} for one in fit.kept]

    monkeypatch.setattr(elimination, "parameters_of", sizes)
    base, rest = (INERTIA, VISCOUS, "coulomb_friction@motor_2"), frozenset({INERTIA, "coulomb_friction@motor_2"})
    search: Any = Search({rest: 2001.0}, {INERTIA: 1.0, VISCOUS: 2.0, "coulomb_friction@motor_2": 500.0}, base)
    search.data.record.command = np.zeros((N, 2))
    assert elimination.reduced(search, Fit(base, 2000.0), [], 0.2).names == rest  # type: ignore[arg-type]


def test_a_further_effect_that_removes_little_is_left_out() -> None:
    every = Fit((COULOMB, BIAS), 2000.0)
    search: Any = Search({frozenset({COULOMB}): 2050.0}, {COULOMB: 900.0, BIAS: 50.0}, (COULOMB,))
    assert elimination.reduced(search, every, [], 0.2).names == {COULOMB}  # type: ignore[arg-type]


def test_of_two_needless_effects_at_a_motor_the_one_that_torques_show_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside friction by the load Coulomb friction is not clear; the part by the load removes little all the same."""

    def sizes(fit: Fit, _: Any) -> list[dict[str, Any]]:
        return [{"size": size_of(1.0, 1.0 if one == COULOMB and LOAD in fit.names else 0.1)} for one in fit.kept]

    monkeypatch.setattr(elimination, "parameters_of", sizes)
    base = (COULOMB, "coulomb_friction@motor_2")
    chi2 = {frozenset(base): 2100.0, frozenset({LOAD, base[1]}): 2001.0}
    search: Any = Search(chi2, {COULOMB: 1.0, LOAD: 100.0, base[1]: 900.0}, base)
    found = elimination.reduced(search, Fit((*base, LOAD), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == set(base)


@pytest.mark.parametrize("premises", [SIMULATED, MEASURED], ids=["simulated", "measured"])
@pytest.mark.parametrize("chi2", [1000.0 - 30.0, 1000.0 + 30.0], ids=["below the floor", "above the floor"])
def test_an_effect_that_gains_nothing_is_left_out_wherever_the_floor_is(chi2: float, premises: Premises) -> None:
    """Half of all logs whose causes are found end below it, by chance."""
    search: Any = Search({frozenset({COULOMB}): chi2 + 0.1}, {COULOMB: 900.0, BIAS: 0.1}, ())
    search.torques_decide, search.premises = False, premises
    assert elimination.reduced(search, Fit((COULOMB, BIAS), chi2), [], 0.2).names == {COULOMB}  # type: ignore[arg-type]


@pytest.mark.parametrize(("viscous", "expected"), [
    (1.0, {INERTIA}),
    (30.0, {INERTIA, VISCOUS}),
], ids=["all needless", "one is needed beside the others"])  # fmt: skip
def test_several_effects_that_gain_nothing_together_are_left_out_with_one_fit(
    viscous: float, expected: set[str]
) -> None:
    """A sum that gains more than its parameters cost is shortened by the effect that gains most."""
    several = (COULOMB, BIAS, LOAD)
    search: Any = Search({frozenset(expected): 1002.0}, dict.fromkeys((*several, VISCOUS), 1.0) | {INERTIA: 900.0}, ())
    search.estimated[VISCOUS] = viscous
    search.torques_decide, search.premises = False, MEASURED
    if viscous > 1:
        search.chi2[frozenset({INERTIA})] = 1400.0
    fits: list[Any] = []
    found = elimination.reduced(search, Fit((*several, VISCOUS, INERTIA), 1000.0), fits, 0.2)  # type: ignore[arg-type]
    assert found.names == expected
    assert [fit.names for fit in fits][:1] == [expected]


def test_of_several_effects_that_a_fit_needs_one_after_the_other_is_left_out() -> None:
    """Linear theory does not see what two of them do together."""
    several = (COULOMB, BIAS, LOAD)
    search: Any = Search({}, dict.fromkeys(several, 1.0) | {INERTIA: 900.0}, ())
    search.torques_decide, search.premises = False, MEASURED
    search.chi2 = {frozenset({INERTIA}): 1500.0, frozenset({INERTIA, BIAS, LOAD}): 1001.0}
    search.chi2 |= {frozenset({INERTIA, COULOMB, one}): 1002.0 for one in (BIAS, LOAD)}
    search.chi2 |= {frozenset({INERTIA, one}): 1500.0 for one in (BIAS, LOAD)}
    found = elimination.reduced(search, Fit((*several, INERTIA), 1000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {INERTIA, BIAS, LOAD}


@pytest.mark.parametrize(("strained", "premises", "expected"), [
    (True, SIMULATED, {COULOMB}),
    (False, SIMULATED, {COULOMB, BIAS}),
    (True, MEASURED, {COULOMB, BIAS}),
])  # fmt: skip
def test_beside_numbers_out_of_tolerance_effects_that_seem_needed_are_tried_as_well(
    strained: bool, premises: Premises, expected: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without an imitation the numbers go back to their tolerances, which linear theory does not see."""
    found = SimpleNamespace(threshold=6.0, beyond_tolerance=lambda _: strained)
    monkeypatch.setattr(elimination, "compared", lambda *_: found)
    search: Any = Search({frozenset({COULOMB}): 990.0, frozenset({BIAS}): 5000.0}, {COULOMB: 9000.0, BIAS: 900.0}, ())
    search.torques_decide, search.premises = False, premises
    every = Fit((COULOMB, BIAS), 1000.0)
    assert elimination.reduced(search, every, [], 0.2).names == expected  # type: ignore[arg-type]


def test_beside_numbers_out_of_tolerance_every_mode_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """By linear theory it is needed most; but springs and inertias far from their values take its place."""
    found = SimpleNamespace(threshold=6.0, beyond_tolerance=lambda _: True)
    monkeypatch.setattr(elimination, "compared", lambda *_: found)
    needed, mode = (COULOMB, VISCOUS, BIAS, INERTIA), "extra_mode@base"
    every = (*needed, mode)
    chi2 = {frozenset({*every} - {one}): 5000.0 for one in needed} | {frozenset(needed): 990.0}
    chi2 |= {frozenset({*needed} - {one}): 5000.0 for one in needed}
    search: Any = Search(chi2, {**dict.fromkeys(needed, 9000.0), mode: 9e4}, ())
    search.torques_decide, search.premises = False, SIMULATED
    assert elimination.reduced(search, Fit(every, 1000.0), [], 0.2).names == {*needed}  # type: ignore[arg-type]


def test_without_time_all_that_seems_needless_is_left_out_at_once() -> None:
    base = (COULOMB, VISCOUS, "coulomb_friction@motor_2")
    search: Any = Search(
        {frozenset({"coulomb_friction@motor_2"}): 2400.0},
        {COULOMB: 20.0, VISCOUS: 10.0, "coulomb_friction@motor_2": 500.0},
        base,
    )
    search.deadline = over()
    found = elimination.reduced(search, Fit(base, 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {"coulomb_friction@motor_2"}


@pytest.mark.parametrize("little", [(1e-5, 1e-9), (0.5, 0.0)], ids=["size zero", "size that changes nothing"])
def test_an_effect_without_a_size_is_left_out_though_its_deviation_is_small(
    little: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = {COULOMB: size_of(1.0, 0.1), VISCOUS: size_of(*little)}
    monkeypatch.setattr(elimination, "parameters_of", lambda fit, _: [{"size": sizes[name]} for name in fit.kept])
    search: Any = Search({frozenset({COULOMB}): 2000.0}, {COULOMB: 900.0, VISCOUS: 1.0}, (COULOMB, VISCOUS))
    found = elimination.reduced(search, Fit((COULOMB, VISCOUS), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {COULOMB}


def test_behind_springs_all_that_seems_needless_is_left_out_at_once() -> None:
    """See test_flexible_drive.py: one friction term would stand for an error of the spring."""
    search: Any = Search({frozenset({BIAS}): 2400.0}, {COULOMB: 20.0, VISCOUS: 10.0, BIAS: 500.0}, (COULOMB, VISCOUS))
    search.null.model.robot.n_coordinates = 4
    found = elimination.reduced(search, Fit((COULOMB, VISCOUS, BIAS), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {BIAS}


@pytest.mark.parametrize(("size", "kept"), [(0.05, False), (0.07, True), (-0.05, False), (-0.07, True)])
def test_an_inertia_is_wrong_from_twice_its_tolerance_on(
    size: float, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = {COULOMB: size_of(1.0, 0.1), INERTIA: size_of(size, 1e-4)}
    monkeypatch.setattr(elimination, "parameters_of", lambda fit, _: [{"size": sizes[name]} for name in fit.kept])
    search: Any = Search({frozenset({COULOMB}): 2000.0}, {COULOMB: 900.0, INERTIA: 1.0}, (COULOMB, INERTIA))
    found = elimination.reduced(search, Fit((COULOMB, INERTIA), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert (INERTIA in found.names) is kept


@pytest.mark.parametrize(("mass", "kept"), [(0.09, False), (0.11, True)])
def test_a_load_is_one_from_a_small_share_of_all_that_moves(
    mass: float, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However clear its mass and place are: 1.7 g at an arm of 15 kg were 2.6 deviations."""
    sizes = {COULOMB: {"size": size_of(1.0, 0.1)}, LEFT_OUT: {"mass": size_of(mass, 1e-4), "x": size_of(0.3, 0.01)}}
    monkeypatch.setattr(elimination, "parameters_of", lambda fit, _: [sizes[name] for name in fit.kept])
    monkeypatch.setattr(elimination, "moved_mass", lambda _: 20.0)
    search: Any = Search({frozenset({COULOMB}): 2000.0}, {COULOMB: 900.0, LEFT_OUT: 1.0}, (COULOMB, LEFT_OUT))
    begin = Fit((COULOMB, LEFT_OUT), 2000.0, free=("size", "mass", "x"))
    found = elimination.reduced(search, begin, [], 0.2)  # type: ignore[arg-type]
    assert (LEFT_OUT in found.names) is kept


@pytest.mark.parametrize(("before", "found"), [
    ((), {COULOMB, VISCOUS, BIAS}),
    ((DRIFT, BIAS), {DRIFT, BIAS}),
], ids=["another effect was found since", "no effect was found since"])  # fmt: skip
def test_friction_that_was_left_out_returns_once_it_is_clear_beside_what_was_found_since(
    before: tuple[str, ...], found: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A law that stood for both kinds of friction gives way to them."""
    monkeypatch.setattr(elimination, "parameters_of", lambda fit, _: [{"size": size_of(1.0, 0.1)} for _ in fit.kept])
    both = frozenset({COULOMB, VISCOUS, BIAS})
    chi2 = {both: 1000.0, both | {DRIFT}: 1000.0}
    search: Any = Search(chi2, {COULOMB: 500.0, VISCOUS: 400.0, BIAS: 900.0, DRIFT: 1.0}, (COULOMB, VISCOUS))
    chosen: Any = Fit((DRIFT, BIAS), 2000.0)
    again = elimination.with_dropped_again(search, Fit(before, 3000.0), chosen, [])  # type: ignore[arg-type]
    assert again.names == found


def test_what_was_exchanged_for_an_effect_that_looks_alike_in_torques_does_not_return() -> None:
    search: Any = Search({}, {}, (BIAS,))
    chosen: Any = Fit((OFFSET,), 2000.0)
    assert elimination.with_dropped_again(search, Fit((BIAS,), 3000.0), chosen, []) is chosen  # type: ignore[arg-type]


def test_a_needed_effect_does_not_keep_a_needless_one_that_was_left_out_with_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without the error of a spring, numbers of the model go far out of tolerance to do its work."""
    without = {frozenset(names): 2000.0 for names in ((COULOMB,), (COULOMB, STIFFNESS), (COULOMB, BIAS))}
    search: Any = Search(without, {COULOMB: 900.0, STIFFNESS: 20.0, BIAS: 10.0}, (COULOMB,))
    search.null.model.robot.n_coordinates = 4
    monkeypatch.setattr(elimination, "strains", lambda _, __, fit, rest: STIFFNESS in fit.names - rest.names)
    found = elimination.reduced(search, Fit((COULOMB, STIFFNESS, BIAS), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {COULOMB, STIFFNESS}


def test_a_further_effect_without_which_a_fit_leaves_much_stays_whatever_linear_theory_says() -> None:
    without = {frozenset({COULOMB}): 2e5, frozenset({COULOMB, STIFFNESS}): 2000.0, frozenset({COULOMB, BIAS}): 2e5}
    search: Any = Search(without, {COULOMB: 900.0, STIFFNESS: 20.0, BIAS: 10.0}, (COULOMB,))
    search.null.model.robot.n_coordinates = 4
    found = elimination.reduced(search, Fit((COULOMB, STIFFNESS, BIAS), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {COULOMB, STIFFNESS}


def test_effects_within_the_floor_are_left_out_one_by_one_after_a_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Linear theory takes two for needless; without the second one far more is left, and it stays."""
    chi2 = {
        frozenset({COULOMB, STIFFNESS}): 110.0,
        frozenset({COULOMB, BIAS}): 900.0,
        frozenset({COULOMB}): 950.0,
    }
    search: Any = Search(chi2, {COULOMB: 900.0, STIFFNESS: 12.0, BIAS: 10.0}, (COULOMB,))
    search.completed = lambda fit: fit
    search.null.model.robot.n_coordinates = 4
    fits: list[Any] = []
    found = elimination.one_by_one(search, Fit((COULOMB, STIFFNESS, BIAS), 100.0), fits)  # type: ignore[arg-type]
    assert found.names == {COULOMB, STIFFNESS}
    assert [fit.names for fit in fits] == [{COULOMB, STIFFNESS}, {COULOMB}, {COULOMB}]


@pytest.mark.parametrize(
    ("quick", "fall", "finished", "kept"),
    [(110.0, 0.0, None, False), (110.0, 50.0, 109.0, False), (900.0, 0.0, 110.0, False), (900.0, 0.0, 890.0, True)],
    ids=["little is left", "no minimum yet", "little in the end", "much in the end"],
)
def test_a_quick_fit_decides_where_one_to_the_end_cannot_decide_otherwise(
    quick: float, fall: float, finished: float | None, kept: bool
) -> None:
    """The sum of squares falls further in a fit to the end: little stays little, and much may become little."""
    search: Any = Search({frozenset({COULOMB}): quick}, {COULOMB: 900.0, BIAS: 10.0}, (COULOMB,))
    search.null.model.robot.n_coordinates = 4
    search.fall, ended = fall, []

    def completed(fit: Fit) -> Fit:
        assert finished is not None
        ended.append(fit)
        return Fit(fit.kept, finished)

    search.completed = completed
    found = elimination.one_by_one(search, Fit((COULOMB, BIAS), 100.0), [])  # type: ignore[arg-type]
    assert found.names == ({COULOMB, BIAS} if kept else {COULOMB})
    assert len(ended) == (finished is not None)
    assert kept or found.chi2 == (finished or quick)


def over() -> Deadline:
    """Return a deadline that is over."""
    return Deadline(interrupted=lambda: True)


@pytest.mark.parametrize(
    ("std", "without", "premises", "kept"),
    [
        (0.5, N, SIMULATED, False),
        (0.3, N, SIMULATED, True),
        (0.5, 2 * N, SIMULATED, True),
        (0.5, N, MEASURED, True),
    ],
    ids=["a size that may be zero", "a clear size", "more than noise left without it", "a measured log"],
)
def test_at_the_noise_an_effect_of_a_simulated_log_stays_where_its_size_is_clear(
    monkeypatch: pytest.MonkeyPatch, std: float, without: float, premises: Premises, kept: bool
) -> None:
    search: Any = Search({frozenset({COULOMB}): without}, {}, ())
    search.premises = premises
    search.completed = lambda fit: fit
    deviations = {COULOMB: 0.01, STIFFNESS: std}
    monkeypatch.setattr(
        elimination, "parameters_of", lambda fit, *_: [{"size": size_of(1.0, deviations[one])} for one in fit.kept]
    )
    monkeypatch.setattr(elimination, "sizes_of", lambda one: one.free)
    monkeypatch.setattr(elimination, "more_than_chance", lambda _, fit: fit.chi2 > 1.2 * N)
    found = elimination.without_unclear(search, Fit((COULOMB, STIFFNESS), float(N)), [])  # type: ignore[arg-type]
    assert (STIFFNESS in found.names) is kept
