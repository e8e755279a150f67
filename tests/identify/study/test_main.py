from __future__ import annotations

from pathlib import Path

import pytest

from flexros.identify.study.__main__ import main


def test_whole_study_runs_on_dask(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    options = [
        "--scenario",
        "identify_e12",
        "--positions",
        "2",
        "--starts",
        "2",
        "--redrawn",
        "2",
        "--candidates",
        "30",
    ]
    assert main([*options, "--out", str(tmp_path)]) == 0
    assert (tmp_path / "study.md").is_file()


def test_folder_that_is_not_there_is_found_before_the_work(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--out", str(tmp_path / "nowhere")]) == 2
    assert "no such folder" in capsys.readouterr().err


def test_unknown_scenario_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--scenario", "identify_seven_axis", "--out", str(tmp_path)]) == 2
    assert "identify_seven_axis" in capsys.readouterr().err
