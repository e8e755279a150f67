"""Small changes that stand for fewer others are replaced by these together."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flexros.gap.fit.least_squares import fit
from flexros.gap.search import regrouping
from flexros.gap.search.regrouping import _that_matter, in_proportion, regrouped, without_tangled
from flexros.gap.settings import DiagnosisSettings
from tests.gap.diagnosis_logs import candidates_of, predictor_of, search_of

if TYPE_CHECKING:
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search

TRUTH = "payload_error@tool:relative=0.002"
AMONG = ("payload_error", "stiffness_error", "motor_inertia_error", "torque_gain_error", "coulomb_friction")


def imitation(search: Search) -> CandidateFit:
    """A gain, an inertia and a spring in place of a load."""
    names = ("torque_gain_error@motor_1", "motor_inertia_error@motor_1", "stiffness_error@body_1.rz")
    predictor = predictor_of(*(candidates_of()[name] for name in names))
    return fit(predictor, search.data, np.zeros(predictor.n_fitted))


@pytest.mark.slow
def test_one_load_replaces_three_numbers_that_stand_for_it() -> None:
    search = search_of(TRUTH, among=AMONG)
    wrong, fits = imitation(search), []
    assert len(wrong.names) == 3
    found = regrouped(search, wrong, search.directions(search.candidates()), fits)
    assert found.names == {"payload_error@tool"}
    assert found.chi2 < 1.01 * wrong.chi2
    assert any(one is found for one in fits)


@pytest.mark.slow
def test_numbers_that_nothing_smaller_replaces_stay() -> None:
    errors = ("motor_inertia_error@motor_1:relative=0.02", "stiffness_error@body_2.rz:relative=0.02")
    search = search_of(*errors, among=AMONG)
    predictor = predictor_of(*(candidates_of()[one.partition(":")[0]] for one in errors))
    right = fit(predictor, search.data, np.zeros(predictor.n_fitted))
    assert regrouped(search, right, search.directions(search.candidates()), []) is right


@pytest.mark.parametrize(("name", "expected"), [
    ("payload_error@tool", True),
    ("torque_bias@motor_1", True),
    ("coulomb_friction@motor_1", False),
    ("delay@all", False),
    ("extra_mode@tool", False),
])  # fmt: skip
def test_numbers_of_the_model_act_in_proportion_to_their_size_and_laws_do_not(name: str, expected: bool) -> None:
    assert in_proportion(candidates_of()[name]) == expected


@pytest.mark.parametrize("enough", [True, False])
def test_of_effects_that_balance_each_other_one_stays_where_it_is_enough(
    enough: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A payload error is not clear beside a load and an offset, and is alone."""
    clear = {"payload_error": 0.5, "tool_load": 1.6, "encoder_offset": 1.7, "viscous_friction": 90.0}

    def fitted(*names: str) -> Any:
        hypothesis = tuple(SimpleNamespace(name=name) for name in names)
        right = enough and set(names) == {"payload_error", "viscous_friction"}
        return SimpleNamespace(hypothesis=hypothesis, names=frozenset(names), chi2=1000.0 if right else 2000.0)

    whole = SimpleNamespace(**{**vars(fitted(*clear)), "chi2": 999.0})

    def unclear(_search: Any, fit: Any, least: float) -> list[str]:
        return [name for name in clear if len(fit.names) == len(clear) and clear[name] < least]

    monkeypatch.setattr(regrouping, "unclear", unclear)
    score = SimpleNamespace(score=lambda fit: -fit.chi2 - 10 * len(fit.names))
    monkeypatch.setattr(regrouping, "compared", lambda *_: score)
    search: Any = SimpleNamespace(
        settings=DiagnosisSettings(),
        data=None,
        premises=SimpleNamespace(library_is_complete=False),
        deadline=SimpleNamespace(stops=lambda: False),
        parallel=lambda stage, work, items: [work(one) for one in items],
        completed=lambda fit: fit,
        without=lambda fit, *names: fitted(*(name for name in clear if name in fit.names - {*names})),
    )
    found, fits = without_tangled(search, whole, []), list[Any]()
    assert found.names == ({"payload_error", "viscous_friction"} if enough else {*clear})
    search.premises = SimpleNamespace(library_is_complete=True)
    assert without_tangled(search, whole, fits) is whole


def test_gains_that_matter_do_most_of_what_all_of_them_do() -> None:
    """The second one does a hundredth of it, and the others half each."""
    worth = np.array([50.0, 1.0, 49.0])
    around: Any = SimpleNamespace(least=200.0, left=lambda changes: 200.0 - float(changes.sum()))
    assert _that_matter(around, worth[None, :]) == [0, 2]
    assert _that_matter(around, worth[None, 1:2]) == [0]
