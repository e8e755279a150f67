"""Files of an identification: a robot that loads, figures that parse, a page."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flexros.errors import InputError
from flexros.identify.report.files import FIGURES, REPORT, ROBOT, make_folder, write_identification
from flexros.identify.result import IdentificationResult
from flexros.robot import load_robot


@pytest.mark.slow
def test_folder_holds_robot_figures_and_page(noisy: IdentificationResult, tmp_path: Path) -> None:
    folder = tmp_path / "new" / "identified"
    write_identification(noisy, folder, "experiment test")
    robot = load_robot(folder / ROBOT)
    nominal, kept = noisy.problem.robot.parameters, noisy.identifiability.names("not_determined")
    assert 0 < len(kept) < len(noisy.fit.names)
    for name, value in zip(noisy.fit.names, noisy.fit.values, strict=True):
        if name in kept:
            assert robot.parameters[name] == nominal[name]
        else:
            assert robot.parameters[name].value == pytest.approx(value)
            assert "experiment test" in robot.parameters[name].source
    content = json.loads((folder / FIGURES).read_text())
    assert [row["name"] for row in content["parameters"]] == list(noisy.fit.names)
    assert content["kept_nominal"] == list(kept) == [row["name"] for row in content["parameters"] if not row["used"]]
    assert (folder / REPORT).stat().st_size > 1_000_000


def test_nothing_is_written_before_all_is_made(
    noisy: IdentificationResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(_result: IdentificationResult) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr("flexros.identify.report.files.identification_report", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_identification(noisy, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_folder_that_cannot_be_made_is_explained(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"the folder .*file/inside' of the identification cannot be made "):
        make_folder(tmp_path / "file" / "inside")
