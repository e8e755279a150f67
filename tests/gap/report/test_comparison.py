"""Diagnoses side by side: the sizes of the first diagnosis of a fixture, changed by hand."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from scipy.stats import chi2

from flexros.errors import InputError
from flexros.gap.report.compared import compared_page, sentence
from flexros.gap.report.comparison import DiagnosisComparison, read_comparison
from flexros.gap.schema import BudgetShare, Cause, CauseParameter, Diagnosis, GapNumbers, ModelNumber


def diagnosis(levels: dict[str, tuple[float, float]], rotor: float | None = None) -> Diagnosis:
    """A diagnosis that found friction of these levels and deviations [Nm] at motors, and a rotor inertia [kg m2]."""
    causes = tuple(
        Cause(
            effect="coulomb_friction",
            location=motor,
            probability=0.99,
            parameters={"level": CauseParameter(value=level, std=std, unit="Nm")},
            closed_fraction=0.4,
        )
        for motor, (level, std) in levels.items()
    )
    budget = tuple(
        BudgetShare.model_validate(
            {"joint": motor, "class": "friction", "effect": "coulomb_friction", "location": motor,
             "share_first": 0.4, "share_last": level / 10, "interval": None}
        )
        for motor, (level, _) in levels.items()
    )  # fmt: skip
    numbers = (
        ModelNumber(location="motor_1", name="motor_1.inertia", nominal=0, value=rotor, std=0.1, unit="kg m2")
        if rotor
        else None
    )
    return Diagnosis(
        verdict="explained" if causes else "no_gap",
        causes=causes,
        ambiguity_groups=(),
        where=(),
        gap=GapNumbers(metric="E", unit="1", before=9.0, after=1.1, noise_floor=1.0, closed_fraction=0.99),
        budget=budget,
        model_numbers=(numbers,) if numbers else (),
        next_experiment=None,
        warnings=(),
        provenance={"log": "a_log", "robot": "ur5e"},
    )


def comparison(*diagnoses: Diagnosis) -> DiagnosisComparison:
    return DiagnosisComparison(tuple(f"d{k}" for k in range(len(diagnoses))), diagnoses)


def test_sizes_that_differ_beyond_their_deviations_are_told() -> None:
    made = comparison(
        diagnosis({"motor_1": (1.0, 0.1), "motor_2": (5.0, 0.2), "motor_3": (2.0, 0.1)}, rotor=1.0),
        diagnosis({"motor_1": (1.1, 0.1), "motor_2": (6.5, 0.2)}, rotor=1.1),
    )
    rows = {row.location: row for row in made.effects}
    assert list(rows) == ["motor_2", "motor_1", "motor_3"], "effects of both first, of these what makes up most"
    assert rows["motor_1"].p_same == pytest.approx(chi2.sf(0.1**2 / (2 * 0.1**2), 1))
    assert rows["motor_2"].p_same == pytest.approx(chi2.sf(1.5**2 / (2 * 0.2**2), 1))
    assert rows["motor_3"].p_same is None
    assert rows["motor_3"].values == (2.0, None)
    assert rows["motor_2"].shares == (0.5, 0.65)
    assert sentence(made) == (
        "2 of 3 effects were found in both diagnoses. Coulomb friction at motor_2 differs beyond their deviations."
    )
    assert [(row.name, row.values) for row in made.numbers] == [("motor_1.inertia", (1.0, 1.1))]


def test_agreement_and_absence_are_told() -> None:
    same = diagnosis({"motor_1": (1.0, 0.1)})
    assert sentence(comparison(same, same, same)) == (
        "1 of 1 effects were found in all 3 diagnoses, and their sizes agree within their standard deviations."
    )
    assert sentence(comparison(diagnosis({}), diagnosis({}))) == "None of the 2 diagnoses found an effect."
    assert sentence(comparison(same, diagnosis({}))) == "0 of 1 effects were found in both diagnoses."


def test_page_has_every_diagnosis_and_value(tmp_path: Path) -> None:
    page = compared_page(
        comparison(diagnosis({"motor_1": (1.0, 0.1)}, rotor=1.0), diagnosis({"motor_1": (2.0, 0.1)}, rotor=1.1))
    )
    for text in ("Comparison of 2 diagnoses", "1.00 Nm (±0.10)", "2.00 Nm (±0.10)", "differ", "motor_1.inertia"):
        assert text in page
    assert page.count("<details>") == 1, "provenance is folded, and what both share stands once"


def test_diagnoses_are_read_and_named_by_their_folders(tmp_path: Path) -> None:
    folders = [tmp_path / "a" / "diagnosis", tmp_path / "b" / "diagnosis", tmp_path / "c"]
    for folder in folders:
        folder.mkdir(parents=True)
        content = diagnosis({"motor_1": (1.0, 0.1)}).model_dump(mode="json", by_alias=True)
        (folder / "diagnosis.json").write_text(json.dumps(content))
    made = read_comparison([*folders[:2], folders[2] / "diagnosis.json"])
    assert made.names == ("a/diagnosis", "b/diagnosis", "c")
    with pytest.raises(InputError, match="at least two"):
        read_comparison(folders[:1])
    (folders[0] / "diagnosis.json").write_text("{}")
    with pytest.raises(InputError, match=r"diagnosis\.json"):
        read_comparison(folders)
