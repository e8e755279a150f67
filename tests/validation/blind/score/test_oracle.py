"""The true structure, fitted, closes the gap; its size is compared with the truth."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.gap.schema import Diagnosis
from flexros.random_streams import Stream
from flexros.validation.blind.make_case import MakeSettings, make_case
from flexros.validation.blind.plan import Case
from flexros.validation.blind.score.coverage import fitted_sizes
from flexros.validation.blind.score.oracle import oracle_fraction
from flexros.validation.blind.seal import Truth, read_case
from tests.validation.blind.cases import answer, diagnosis, truth

SETTINGS = MakeSettings(3, Stream.BLIND_DEVELOPMENT, (6.0, 6.0, 4.0))
CASE = Case(2, "single", "four_mass_linear", ("torque_bias",), "strong", "exact", False)


@pytest.mark.slow
def test_true_effect_closes_the_gap(tmp_path: Path) -> None:
    make_case(CASE, SETTINGS, tmp_path / "logs", tmp_path / "truth")
    hidden = Truth.model_validate_json((tmp_path / "truth" / "case_0002.json").read_bytes())
    folder = tmp_path / "logs" / "case_0002"
    found = oracle_fraction(folder, read_case(folder), hidden)
    assert found == pytest.approx(1.0, abs=0.05)
    assert oracle_fraction(folder, read_case(folder), hidden.model_copy(update={"kind": "pair"})) is None


def said(value: float, std: float) -> Diagnosis:
    plain = diagnosis("explained", "torque_bias@motor_1").model_dump(by_alias=True)
    plain["causes"][0]["parameters"] = {"level": {"value": value, "std": std, "unit": "Nm"}}
    return Diagnosis.model_validate(plain)


def test_interval_covers_the_truth_or_not() -> None:
    hidden = truth("single", "torque_bias@motor_1")
    bias = hidden.deviations[0].model_copy(update={"parameters": {"level": 1.0}})
    hidden = hidden.model_copy(update={"deviations": (bias,)})
    answers = [answer(hidden, said(1.1, 0.1)), answer(hidden, said(1.3, 0.1))]
    other = answer(hidden.model_copy(update={"nuisance": "tolerance_1"}), said(1.3, 0.1))
    assert [one.covered for one in fitted_sizes([*answers, other])] == [True, False]
