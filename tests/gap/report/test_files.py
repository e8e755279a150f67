"""The folder of a diagnosis is there as a whole or not at all."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from flexros.effects.patching.patched_robot import load_patched
from flexros.errors import InputError
from flexros.gap.report import files
from flexros.gap.report.files import check_folder, write_diagnosis
from flexros.gap.result import DiagnosisResult
from flexros.gap.schema import Diagnosis

Diagnosed = Callable[[str], DiagnosisResult]


def test_the_three_files_say_the_same(diagnosed: Diagnosed, tmp_path: Path) -> None:
    result, folder = diagnosed("explained"), tmp_path / "out"
    assert write_diagnosis(result, "four_mass_linear", folder) == ("diagnosis.json", "patch.yaml", "report.html")
    read = json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))
    assert read["schema"] == 2
    assert Diagnosis.model_validate(read) == result.diagnosis
    assert load_patched(folder / "patch.yaml").placed == result.patch
    assert (folder / "patch.yaml").read_text(encoding="utf-8").splitlines()[0] in (folder / "report.html").read_text(
        encoding="utf-8"
    )
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.slow
def test_without_a_gap_there_is_no_patch(diagnosed: Diagnosed, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    write_diagnosis(diagnosed("explained"), "four_mass_linear", folder)
    write_diagnosis(diagnosed("no_gap"), "four_mass_linear", folder)
    assert sorted(path.name for path in folder.iterdir()) == ["diagnosis.json", "report.html"]


@pytest.mark.slow
def test_a_diagnosis_that_breaks_off_leaves_the_old_one(
    diagnosed: Diagnosed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    write_diagnosis(diagnosed("explained"), "four_mass_linear", folder)

    def no_room(path: Path, text: str, what: str) -> None:
        raise InputError(f"the {what} cannot be written to '{path}' (No space left on device)")

    monkeypatch.setattr(files, "write_result", no_room)
    with pytest.raises(InputError, match="No space left"):
        write_diagnosis(diagnosed("no_gap"), "four_mass_linear", folder)
    assert sorted(path.name for path in folder.iterdir()) == ["diagnosis.json", "patch.yaml", "report.html"]
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_folder_with_other_files_is_refused(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work", encoding="utf-8")
    with pytest.raises(InputError, match=r"holds thesis\.tex: only an empty folder or one of an earlier diagnosis"):
        check_folder(tmp_path)


def test_a_report_that_is_no_diagnosis_is_refused(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("of a run", encoding="utf-8")
    with pytest.raises(InputError, match=r"holds no diagnosis\.json"):
        check_folder(tmp_path)


def test_a_file_is_refused_as_folder(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="is a file; give a folder"):
        check_folder(tmp_path / "out")
    with pytest.raises(InputError, match=r"cannot be written to "):
        check_folder(tmp_path / "out" / "below" / "it")
