"""A hidden effect found, its repair measured on another log."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import flexros
from flexros.errors import InputError

pytestmark = pytest.mark.slow
LEVEL = 0.05
HIDDEN: dict[str, Any] = {
    "model": "four_mass_linear",
    "effects": [f"coulomb_friction@motor_1:level={LEVEL}"],
    "settings": {"diagnosis.length": 10, "diagnosis.parts": ["creep", "moves"], "diagnosis.poses": 1},
}


@pytest.fixture(scope="module")
def diagnosis() -> flexros.Diagnosis:
    run = flexros.run("diagnosis", **HIDDEN)
    return flexros.diagnose(run, "four_mass_linear", effects=["coulomb_friction", "delay"])


def test_cause_is_found_with_its_size(diagnosis: flexros.Diagnosis) -> None:
    assert diagnosis.verdict == "explained"
    row = diagnosis.to_pandas().loc[("coulomb_friction", "motor_1", "level")]
    assert row["value"] == pytest.approx(LEVEL, abs=4 * row["std"])
    assert row["unit"] == "Nm"
    assert diagnosis.as_dict()["schema"] == 2


def test_repair_closes_the_gap_of_another_log(diagnosis: flexros.Diagnosis) -> None:
    other = flexros.run("diagnosis", **HIDDEN, seed=2)
    gap = flexros.measure_gap(other, "four_mass_linear", repaired=diagnosis.repaired)
    assert not gap.significant
    assert gap.to_pandas()["before"] > 100 * gap.to_pandas()["after"]
    assert "No gap" in gap._repr_html_()
    assert gap.plot().data


def test_diagnosis_shows_plots_and_writes_itself(diagnosis: flexros.Diagnosis, tmp_path: Path) -> None:
    assert "Coulomb friction" in diagnosis._repr_html_()
    assert diagnosis.plot("gap").data
    files = diagnosis.write(tmp_path / "diagnosis")
    assert {file.name for file in files} == {"diagnosis.json", "patch.yaml", "report.html"}
    (law,) = flexros.load_model(tmp_path / "diagnosis" / "patch.yaml").laws
    assert law.name == "coulomb_friction@motor_1"


def test_model_without_a_file_is_not_written(diagnosis: flexros.Diagnosis, tmp_path: Path) -> None:
    changed = flexros.load_robot("four_mass_linear").with_values({"body_1.rz.stiffness": 90.0})
    with pytest.raises(InputError, match="no file"):
        flexros.Diagnosis(diagnosis.result, changed).write(tmp_path / "diagnosis")


@pytest.mark.parametrize("tolerance", [{"mass": 0.1}, {"stiffness": 1.5}])
def test_bad_tolerance_is_refused(tolerance: dict[str, float]) -> None:
    with pytest.raises(InputError, match="stiffness|allowed"):
        flexros.measure_gap(Path("nowhere"), "two_mass", tolerance=tolerance)
