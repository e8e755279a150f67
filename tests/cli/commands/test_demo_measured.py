"""The measured machine at the end of the demonstration."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from flexros.cli.commands import demo, demo_measured, demo_repair
from flexros.cli.commands.demo_measured import OWNER, RECORDED, Budgeted, budgeted, print_budget
from tests.cli.commands.test_demo_repair import stand_in

MOST = 400_000
"""Size that the recordings may have in the repository [bytes]."""


def test_the_recordings_come_with_their_licence_and_source() -> None:
    licence, about = ((RECORDED / name).read_text() for name in ("LICENSE", "README.md"))
    assert "BSD 3-Clause License" in licence
    assert "DFKI" in licence
    assert "1e8544e67f3da72a51ee52fbbb278e131ce2a43f" in about
    assert sum(file.stat().st_size for file in RECORDED.iterdir()) < MOST


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Budgeted:
    return budgeted(tmp_path_factory.mktemp("demo"), lambda what, share: None)


@pytest.mark.slow
def test_friction_of_both_joints_is_found_and_most_of_the_gap_closed(measured: Budgeted) -> None:
    diagnosis = measured.result.diagnosis
    frictions = {one.location for one in diagnosis.causes if one.effect == "coulomb_friction" and one.probability > 0.9}
    assert frictions == {"motor_1", "motor_2"}
    assert diagnosis.gap.closed_fraction is not None
    assert diagnosis.gap.closed_fraction > 0.8


@pytest.mark.slow
def test_no_name_hangs_on_the_tolerances_of_its_model(measured: Budgeted) -> None:
    rows = measured.result.diagnosis.tolerance_sensitivity
    assert {row.location for row in rows if row.effect == "coulomb_friction"} == {"motor_1", "motor_2"}
    assert not any(row.changes for row in rows)


@pytest.mark.slow
def test_the_waterfall_of_the_machine_adds_up(measured: Budgeted) -> None:
    """Its model has tolerances, which are fitted again with every part of the effects."""
    diagnosis = measured.result.diagnosis
    assert sum(one.before for one in diagnosis.waterfall) == pytest.approx(1.0)
    left = sum(one.share for one in diagnosis.unexplained if one.regime == "all")
    assert sum(one.left for one in diagnosis.waterfall) == pytest.approx(left, abs=0.01)
    for one in diagnosis.waterfall:
        assert one.before - sum(step.share for step in one.steps) == pytest.approx(one.left, abs=0.005)


@pytest.mark.slow
def test_the_output_says_whose_data_it_is_and_what_is_left(
    measured: Budgeted, capfd: pytest.CaptureFixture[str]
) -> None:
    print_budget(measured)
    printed = " ".join(capfd.readouterr().out.split())
    assert " ".join(OWNER.split()) in printed
    assert "motor_1" in printed
    assert "Left unexplained" in printed


@pytest.mark.slow
def test_figures_are_in_json(measured: Budgeted) -> None:
    figures = measured.as_dict()
    assert figures["data"] == OWNER
    assert {"budget", "waterfall", "unexplained"} <= figures.keys()
    assert (measured.folder / "report.html").is_file()


@pytest.mark.slow
def test_the_demonstration_ends_with_repair_and_measured_machine(
    flexros: Callable[..., Any], measured: Budgeted, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    last = [case for case in demo.cases() if case.label == "circle_dae2"]
    monkeypatch.setattr(demo, "cases", lambda: tuple(last))
    monkeypatch.setattr(demo_repair, "_diagnosed", stand_in(150.0))
    monkeypatch.setattr(demo_measured, "budgeted", lambda folder, progress: measured)
    ended = flexros("demo", "--transport", "direct", "--json", "--out", str(tmp_path / "out"))
    assert ended.code == 0, ended.err
    figures = json.loads(ended.out)
    assert figures["measured"] == json.loads(json.dumps(measured.as_dict()))
    assert figures["repair"]["verdict"] == "explained"
    assert figures["repair"]["path_error_after_m"] < 0.05 * figures["repair"]["path_error_before_m"]
    assert (tmp_path / "out" / demo_repair.REPORT).stat().st_size > 100_000
