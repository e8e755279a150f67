"""Diagnosis from the command line: what it prints and writes, and how it ends."""

from __future__ import annotations

import json
import os
import signal
from dataclasses import replace
from pathlib import Path

import pytest

from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.kinds.base import PlacedEffect
from flexros.effects.left_out import RotorInertia
from flexros.effects.patching.patched_robot import load_patched
from flexros.errors import RunError
from flexros.gap import diagnose as diagnosis_module
from flexros.gap.prediction.predicted_log import PredictedLog
from flexros.gap.result import DiagnosisResult, Explanation
from flexros.gap.schema import Diagnosis
from flexros.gap.search.fits import candidate_fits as search
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.settings import DiagnosisSettings, NoiseSettings
from flexros.logs.write_log import write_log
from flexros.record.record import Record
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow

PARTS = ["creep", "multisine", "moves"]
HIDDEN = "coulomb_friction@motor_1:level=0.05"
GAP = {"metric": "E", "unit": "1", "before": 1.02, "noise_floor": 1.0}


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Ten seconds of the diagnosis experiment on a robot with hidden friction."""
    values = {"diagnosis.length": 10, "diagnosis.parts": PARTS, "plant.effects": [HIDDEN], "seed": 3}
    folder = tmp_path_factory.mktemp("bags") / "hidden"
    write_log(closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(values, "test"))), folder)
    return str(folder)


@pytest.fixture
def answered(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, object]]:
    """Answer "no gap" without work; returns what was asked."""
    asked: list[dict[str, object]] = []

    def answer(record: Record, robot: object, **given: object) -> DiagnosisResult:
        asked.append({"record": record, **given})
        empty = PredictedLog(0 * record.position, 1 + 0 * record.position[0])
        told = Diagnosis(
            schema=2, verdict="no_gap", causes=(), ambiguity_groups=(), where=(), gap=GAP, next_experiment=None,
            warnings=("the log is short",), provenance={},
        )  # fmt: skip
        nominal = load_robot("four_mass_linear")
        return DiagnosisResult(told, nominal, record, None, Explanation("nominal", empty), null_probability=1.0)

    monkeypatch.setattr(diagnosis_module, "diagnose", answer)
    return asked


@pytest.fixture
def few_candidates(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let few effects compete, so that the answer comes soon."""
    names = {"coulomb_friction", "viscous_friction", "stiffness_error", "backlash"}
    every = search.list_candidates
    few = lambda *given, **named: tuple(one for one in every(*given, **named) if one.effect.name in names)  # noqa: E731
    monkeypatch.setattr(search, "list_candidates", few)


def test_hidden_friction_is_found_and_the_patch_names_it(flexros, bag: str, tmp_path: Path, few_candidates) -> None:
    out = tmp_path / "out"
    ended = flexros("diagnose", bag, "--model", "four_mass_linear", "--out", str(out))
    assert ended.code == 1, ended.err
    assert ended.out.startswith("explained: The gap comes from Coulomb friction at motor_1, 50.0")
    for text in ("Nothing", "Where it shows:", "Gap (mean squared prediction error 0.1 s ahead", f"written: {out}"):
        assert text in ended.out
    read = Diagnosis.model_validate(json.loads((out / "diagnosis.json").read_text(encoding="utf-8")))
    assert read.partial is None
    assert (read.causes[0].effect, read.causes[0].location) == ("coulomb_friction", "motor_1")
    assert read.gap.closed_fraction == pytest.approx(1.0, abs=0.02)
    (effect,) = load_patched(out / "patch.yaml").placed
    assert effect.effect.model_dump()["level"] == pytest.approx(0.05, rel=0.01)
    assert "Disturbance torque over speed, motor_1" in (out / "report.html").read_text(encoding="utf-8")
    for stage in ("nominal model", "where", "causes", "answer", "writing"):  # stderr is no terminal here
        assert any(f"s: {stage}," in line for line in ended.err.splitlines())


def test_without_a_gap_the_code_is_zero_and_there_is_no_patch(flexros, bag: str, tmp_path: Path, answered) -> None:
    out = tmp_path / "out"
    ended = flexros("diagnose", bag, "--model", "four_mass_linear", "--out", str(out), "--json")
    assert ended.code == 0, ended.err
    assert json.loads(ended.out) == json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert sorted(path.name for path in out.iterdir()) == ["diagnosis.json", "report.html"]


def test_no_gap_of_a_model_that_lacks_a_number_goes_on_with_the_patch(
    flexros, bag: str, tmp_path: Path, answered, monkeypatch
) -> None:
    answer, rotor = diagnosis_module.diagnose, PlacedEffect(RotorInertia(added=0.1), "motor_1")
    monkeypatch.setattr(diagnosis_module, "diagnose", lambda *of, **by: replace(answer(*of, **by), patch=(rotor,)))
    ended = flexros("diagnose", bag, "--model", "four_mass_linear", "--out", str(tmp_path / "out"))
    assert f"Next: flexros monitor {bag} --model {tmp_path / 'out' / 'patch.yaml'} --calibrate" in ended.err


@pytest.mark.parametrize(
    ("stated", "found", "imported", "expected"),
    [
        ("", 0.05, True, None),
        ("", 0.005, True, "torque=0.005"),
        ("", 0.0, False, None),
        ("stiffness=0.03", 0.005, True, "stiffness=0.03"),
    ],
    ids=["usual", "torques are better", "simulated", "as it was stated"],
)
def test_another_log_is_compared_with_the_tolerances_of_the_diagnosis(
    flexros, bag: str, tmp_path: Path, answered, monkeypatch, stated: str, found: float, imported: bool, expected
) -> None:
    answer, friction = diagnosis_module.diagnose, PlacedEffect(CoulombFriction(level=0.1), "motor_1")

    def explained(record: Record, *of, **by) -> DiagnosisResult:
        result = answer(replace(record, imported=imported), *of, **by)
        told = result.diagnosis.model_copy(update={"verdict": "explained"})
        settings = DiagnosisSettings(noise=NoiseSettings(signal_tolerance=found))
        return replace(result, diagnosis=told, patch=(friction,), settings=settings)

    monkeypatch.setattr(diagnosis_module, "diagnose", explained)
    ended = flexros(
        "diagnose", bag, "--model", "four_mass_linear", "--out", str(tmp_path / "out"),
        *(["--tolerance", stated] if stated else []),
    )  # fmt: skip
    (suggested,) = (line for line in ended.err.splitlines() if line.startswith("Next: flexros gap ANOTHER_LOG"))
    assert suggested.partition(" --tolerance ")[2] == (expected or "")


def test_warnings_are_printed(flexros, bag: str, tmp_path: Path, answered) -> None:
    ended = flexros("diagnose", bag, "--model", "four_mass_linear", "--out", str(tmp_path / "out"))
    assert "warning: the log is short" in ended.out


def test_holdout_and_tolerance_reach_the_diagnosis(flexros, bag: str, tmp_path: Path, answered) -> None:
    ended = flexros(
        "diagnose", bag, "--model", "four_mass_linear", "--holdout", bag, "--tolerance", "stiffness=0.03,damping=0.3",
        "--out", str(tmp_path / "out"),
    )  # fmt: skip
    assert ended.code == 0, ended.err
    assert answered[0]["holdout"].name == answered[0]["record"].name == "hidden"
    assert answered[0]["tolerance"] == {"stiffness": 0.03, "damping": 0.3}


def test_a_folder_that_holds_something_else_is_refused_before_the_work(flexros, tmp_path: Path, answered) -> None:
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    ended = flexros("diagnose", "no such bag", "--model", "four_mass_linear", "--out", str(tmp_path))
    assert ended.code == 2
    assert "holds notes.txt" in ended.err
    assert not answered


def test_a_diagnosis_that_breaks_off_leaves_nothing(flexros, bag: str, tmp_path: Path, monkeypatch) -> None:
    def breaks(*args: object, **given: object) -> DiagnosisResult:
        raise RunError("the prediction diverged")

    monkeypatch.setattr(diagnosis_module, "diagnose", breaks)
    ended = flexros("diagnose", bag, "--model", "four_mass_linear", "--out", str(tmp_path / "out"))
    assert (ended.code, ended.err) == (3, "flexros: the prediction diverged\n")
    assert not list(tmp_path.iterdir())


def test_a_log_that_is_not_there_is_bad_input(flexros, tmp_path: Path) -> None:
    ended = flexros("diagnose", str(tmp_path / "gone"), "--model", "four_mass_linear", "--out", str(tmp_path / "out"))
    assert ended.code == 2
    assert "there is no log at" in ended.err


def test_limits_of_the_search_reach_the_diagnosis(flexros, bag: str, tmp_path: Path, answered) -> None:
    ended = flexros(
        "diagnose", bag, "--model", "four_mass_linear", "--out", str(tmp_path / "out"), "--joints", "motor_1",
        "--effects", "backlash, delay", "--time-limit", "60",
    )  # fmt: skip
    assert ended.code == 0, ended.err
    settings = answered[0]["settings"]
    assert settings.time_limit == 60.0
    assert (settings.search.joints, settings.search.effects) == (("motor_1",), ("backlash", "delay"))


@pytest.mark.parametrize(
    ("option", "value", "allowed"),
    [("--joints", "motor_9", "motor_1"), ("--effects", "backlach", "backlash"), ("--time-limit", "0", "above 0 s")],
)
def test_limits_that_make_no_sense_are_bad_input(
    flexros, bag: str, tmp_path: Path, option: str, value: str, allowed: str
) -> None:
    out = tmp_path / "out"
    ended = flexros("diagnose", bag, "--model", "four_mass_linear", "--out", str(out), option, value)
    assert ended.code == 2
    assert ended.err.startswith(f"flexros: {option}: ")
    assert value in ended.err
    assert allowed in ended.err
    assert not out.exists()


def interrupts(monkeypatch: pytest.MonkeyPatch, step: str, times: int) -> None:
    """Press Ctrl-C when a step of the search has begun."""
    parallel, left = Search.parallel, [times]

    def pressed(search: Search, name: str, *given: object, **named: object) -> list[object]:
        while name == step and left[0]:
            left[0] -= 1
            os.kill(os.getpid(), signal.SIGINT)
        return parallel(search, name, *given, **named)

    monkeypatch.setattr(Search, "parallel", pressed)


def test_an_interrupted_search_is_written_as_partial(
    flexros, bag: str, tmp_path: Path, few_candidates, monkeypatch
) -> None:
    interrupts(monkeypatch, "best effects", 1)
    out = tmp_path / "out"
    ended = flexros("diagnose", bag, "--model", "four_mass_linear", "--out", str(out))
    assert ended.code == 1, ended.err
    assert "interrupted by Ctrl-C" in ended.err
    assert "Partial result" in ended.out
    read = Diagnosis.model_validate(json.loads((out / "diagnosis.json").read_text(encoding="utf-8")))
    assert read.partial is not None
    assert read.partial.reason == "interrupted"
    assert (read.causes[0].effect, read.causes[0].location) == ("coulomb_friction", "motor_1")
    assert "Partial result" in (out / "report.html").read_text(encoding="utf-8")


def test_a_second_interrupt_ends_the_command_and_leaves_nothing(
    flexros, bag: str, tmp_path: Path, few_candidates, monkeypatch
) -> None:
    interrupts(monkeypatch, "best effects", 2)
    ended = flexros("diagnose", bag, "--model", "four_mass_linear", "--out", str(tmp_path / "out"))
    assert ended.code == 130
    assert not list(tmp_path.iterdir())
