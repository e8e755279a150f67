"""The end of the demonstration, with a stand-in for the diagnosis (which has tests of its own)."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from flexros.cli.commands import demo_repair
from flexros.errors import RunError
from flexros.gap.schema import Cause, Diagnosis, GapNumbers
from flexros.logs.reader import read_log
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow

Progress = Callable[[str, float], None]


def diagnosis(*causes: Cause) -> Diagnosis:
    return Diagnosis(
        schema=2,
        verdict="explained" if causes else "no_gap",
        causes=causes,
        ambiguity_groups=(),
        where=(),
        gap=GapNumbers(metric="prediction error", unit="1", before=2.0, after=1.0, noise_floor=1.0),
        next_experiment=None,
        warnings=(),
        provenance={},
    )


FRICTION = Cause(effect="coulomb_friction", location="motor_1", probability=1.0, parameters={}, closed_fraction=1.0)


def stand_in(level: float | None) -> Callable[[Path, str, Path, Progress], tuple[Diagnosis, Path | None]]:
    """Diagnosis that finds Coulomb friction at the first motor of a level [Nm], or nothing."""

    def diagnosed(log: Path, model: str, folder: Path, progress: Progress) -> tuple[Diagnosis, Path | None]:
        assert read_log(log).joint_commands is not None
        progress("stand-in", 0.5)
        if level is None:
            return diagnosis(), None
        folder.mkdir()
        effect = {"effect": "coulomb_friction", "location": "motor_1", "parameters": {"level": level}}
        (folder / "patch.yaml").write_text(json.dumps({"robot": model, "effects": [effect]}))
        return diagnosis(FRICTION), folder / "patch.yaml"

    return diagnosed


def repaired(folder: Path, monkeypatch: pytest.MonkeyPatch, level: float | None) -> demo_repair.Repair:
    monkeypatch.setattr(demo_repair, "_diagnosed", stand_in(level))
    return demo_repair.repair(folder, "direct", lambda what, share: None)


def test_a_log_with_the_hidden_effect_is_diagnosed_and_the_path_error_falls_to_that_without_effect(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = repaired(tmp_path, monkeypatch, 150.0)
    figures = found.as_dict()
    assert figures["path_error_before_m"] > 3e-3
    assert figures["path_error_after_m"] < 1.3 * figures["path_error_without_effect_m"] < 1e-4
    assert figures["causes"][0]["effect"] == "coulomb_friction"
    ran = json.loads((tmp_path / "diagnosis_log" / "provenance.json").read_text())["scenario"]
    assert ran["robot"] == "e12"
    assert tuple(ran["plant"]["effects"]) == load_scenario(demo_repair.HIDDEN).plant.effects
    assert ran["feedforward_model"] is None
    assert [run.label for run in found.runs] == [
        "hidden effect, nominal model",
        "hidden effect, repaired model",
        "without hidden effect",
    ]
    demo_repair.print_repair(found, tmp_path)
    printed = capsys.readouterr().out
    assert f"{1e3 * figures['path_error_before_m']:.3f}" in printed
    assert f"{1e3 * figures['path_error_after_m']:.3f}" in printed
    assert str(tmp_path / "diagnosis" / "patch.yaml") in printed


def test_nothing_found_is_said_and_nothing_repaired(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = repaired(tmp_path, monkeypatch, None)
    assert found.after is None
    assert found.as_dict()["path_error_after_m"] is None
    demo_repair.print_repair(found, tmp_path)
    assert capsys.readouterr().err == "flexros: the diagnosis found no effect to repair the model with\n"


def test_a_run_that_breaks_off_ends_the_repair(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    unstable = load_scenario(demo_repair.HIDDEN).with_values({"controller.kp": 1e9})
    monkeypatch.setattr("flexros.scenario.scenario.load_scenario", lambda name: unstable)
    with pytest.raises(RunError, match=r"without_effect: .*not finite"):
        repaired(tmp_path, monkeypatch, 150.0)
