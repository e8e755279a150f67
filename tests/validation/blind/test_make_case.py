"""Making, sealing, diagnosing and scoring cases of short logs."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.gap.checked_log import checked_log
from flexros.gap.result import DiagnosisResult
from flexros.logs.reader import read_log
from flexros.random_streams import Stream
from flexros.robot import load_robot
from flexros.validation.blind import diagnose_case as blind_run
from flexros.validation.blind.diagnose_case import case_folders, diagnose_case, waiting
from flexros.validation.blind.draw.case_robots import case_robot
from flexros.validation.blind.make_case import MakeSettings, make_case
from flexros.validation.blind.plan import Case
from flexros.validation.blind.score.score import read_answers
from flexros.validation.blind.seal import DIAGNOSIS_FILE, Truth
from tests.validation.blind.cases import diagnosis

pytestmark = pytest.mark.slow

SETTINGS = MakeSettings(11, Stream.BLIND_DEVELOPMENT, (4.0, 4.0, 4.0), "secret")
CASES = (
    Case(0, "single", "four_mass_linear", ("torque_bias",), "medium", "exact", False),
    Case(1, "null", "four_mass_linear", (), "none", "tolerance_3", True),
)


class Answered:
    """Stand-in for the result of a diagnosis."""

    diagnosis = diagnosis("no_gap")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("blind")
    for case in CASES:
        make_case(case, SETTINGS, folder / "logs", folder / "truth")
    return folder


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Answer without looking; gives the names of the cases that were requested."""
    asked: list[str] = []

    def diagnosed(folder: Path, case: object) -> DiagnosisResult:
        del case
        asked.append(folder.name)
        return Answered()  # type: ignore[return-value]

    monkeypatch.setattr(blind_run, "diagnosed", diagnosed)
    return asked


def truth(made: Path, name: str) -> Truth:
    return Truth.model_validate_json((made / "truth" / f"{name}.json").read_bytes())


def test_truth_tells_what_is_hidden_and_how_large(made: Path) -> None:
    hidden = truth(made, "case_0000")
    assert [one.place for one in hidden.deviations] == ["torque_bias@motor_1"]
    assert 40 < hidden.gain < 700
    assert truth(made, "case_0001").deviations == ()


def test_nothing_beside_the_logs_tells_what_is_hidden(made: Path) -> None:
    texts = [path.read_text() for path in (made / "logs").rglob("*") if path.suffix in (".json", ".yaml")]
    names = [str(path.relative_to(made)) for path in (made / "logs").rglob("*")]
    assert not [text for text in (*texts, *names) if "bias" in text or "secret" in text]
    assert not list((made / "logs").rglob("case_*/truth*"))


def test_logs_are_records_of_the_nominal_robot_and_declare_its_tolerance(made: Path) -> None:
    folder = made / "logs" / "case_0001"
    robot = load_robot(folder / "robot.yaml")
    assert robot.parameters["body_2.rz.stiffness"].tolerance == pytest.approx(0.03)
    assert robot.parameters["body_2.rz.damping"].tolerance == pytest.approx(0.3)
    for log in ("fit", "holdout", "third"):
        record = checked_log(read_log(folder / log), robot, name=log)
        assert record.simulated
        assert record.tool is not None
        assert record.duration > 3.9
        assert np.all(np.isfinite(record.position))


def test_making_again_gives_the_same_logs(made: Path, tmp_path: Path) -> None:
    make_case(CASES[0], SETTINGS, tmp_path / "logs", tmp_path / "truth")
    first, again = (read_log(folder / "logs" / "case_0000" / "fit") for folder in (made, tmp_path))
    assert np.array_equal(first.joint_states.position, again.joint_states.position)  # type: ignore[arg-type]


def test_rounding_encoders_give_multiples_of_the_stated_step_and_change_nothing_else(
    made: Path, tmp_path: Path
) -> None:
    """The step is a condition, drawn from a stream of its own: nominal model and reference stay as they were."""
    settings = replace(SETTINGS, encoder_steps=(0.3, 1.0))
    make_case(CASES[1], settings, tmp_path / "logs", tmp_path / "truth")
    rounded = truth(tmp_path, "case_0001")
    factor = rounded.conditions["encoder_step"]
    assert 0.3 <= factor <= 1.0
    assert rounded.deviations == ()
    for log in ("fit", "holdout", "third"):
        smooth, seen = (read_log(folder / "logs" / "case_0001" / log) for folder in (made, tmp_path))
        position = seen.joint_states.position
        assert position is not None
        steps = position / (factor * case_robot("four_mass_linear").encoder_noise)
        assert np.abs(steps - np.rint(steps)).max() < 1e-6
        assert np.diff(np.unique(np.rint(steps))).min() == 1
        assert np.array_equal(seen.joint_reference.position, smooth.joint_reference.position)  # type: ignore[union-attr, arg-type]
    robots = [(folder / "logs" / "case_0001" / "robot.yaml").read_text() for folder in (made, tmp_path)]
    assert robots[0] == robots[1]


def test_truth_without_rounding_says_nothing_of_it(made: Path) -> None:
    """The text of a truth, and so its seal, is that from before encoders could round."""
    assert set(truth(made, "case_0001").conditions) == {"colour", "late", "stamps", "tool_late"}
    positions = read_log(made / "logs" / "case_0001" / "fit").joint_states.position
    assert positions is not None
    assert len(np.unique(positions)) == positions.size


def test_case_that_is_there_is_kept(made: Path) -> None:
    file = made / "logs" / "case_0000" / "case.json"
    before = file.stat().st_mtime_ns
    make_case(CASES[0], SETTINGS, made / "logs", made / "truth")
    assert file.stat().st_mtime_ns == before


def copied(made: Path, tmp_path: Path) -> Path:
    import shutil

    shutil.copytree(made, tmp_path / "copy")
    return tmp_path / "copy"


def test_run_goes_on_where_it_was_stopped(made: Path, tmp_path: Path, quick: list[str]) -> None:
    logs = copied(made, tmp_path) / "logs"
    diagnose_case(case_folders(logs)[0])
    assert [folder.name for folder in waiting(logs)] == ["case_0001"]
    for folder in waiting(logs):
        diagnose_case(folder, keep_logs=False)
    assert quick == ["case_0000", "case_0001"]
    assert waiting(logs) == ()
    assert (logs / "case_0000" / "fit").exists()
    assert not (logs / "case_0001" / "fit").exists()


def test_log_that_is_refused_is_an_answer(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(folder: Path, case: object) -> DiagnosisResult:
        raise InputError("too short")

    monkeypatch.setattr(blind_run, "diagnosed", refuse)
    folder = copied(made, tmp_path)
    diagnose_case(folder / "logs" / "case_0000")
    assert (folder / "logs" / "case_0000" / "failure.txt").read_text() == "too short\n"
    assert [one.diagnosis for one in read_answers(folder / "logs", folder / "truth")] == [None]


def test_fault_of_the_diagnosis_is_kept_with_its_traceback(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(folder: Path, case: object) -> DiagnosisResult:
        raise ZeroDivisionError("of the diagnosis")

    monkeypatch.setattr(blind_run, "diagnosed", fail)
    logs = copied(made, tmp_path) / "logs"
    diagnose_case(logs / "case_0000")
    assert "Traceback" in (logs / "case_0000" / "failure.txt").read_text()
    assert blind_run.failures(logs) == {"case_0000": "ZeroDivisionError: of the diagnosis"}


@pytest.mark.usefixtures("quick")
def test_changed_truth_is_refused(made: Path, tmp_path: Path) -> None:
    folder = copied(made, tmp_path)
    for case in case_folders(folder / "logs"):
        diagnose_case(case)
    assert len(read_answers(folder / "logs", folder / "truth")) == 2
    file = folder / "truth" / "case_0000.json"
    content = json.loads(file.read_text())
    file.write_text(json.dumps({**content, "kind": "null", "deviations": [], "gains": []}))
    with pytest.raises(InputError, match=r"case_0000.json' has SHA-256 .* sealed with .*: one of them was changed"):
        read_answers(folder / "logs", folder / "truth")


@pytest.mark.usefixtures("quick")
def test_changed_nominal_model_is_refused(made: Path, tmp_path: Path) -> None:
    folder = copied(made, tmp_path)
    diagnose_case(folder / "logs" / "case_0000")
    robot = folder / "logs" / "case_0000" / "robot.yaml"
    robot.write_text(robot.read_text() + "\n")
    with pytest.raises(InputError, match=r"robot.yaml in the folder of case_0000 is not the one that was sealed"):
        read_answers(folder / "logs", folder / "truth")


def test_score_before_run_says_so(made: Path) -> None:
    assert not (made / "logs" / "case_0000" / DIAGNOSIS_FILE).exists()
    with pytest.raises(InputError, match="no case in '.*' is diagnosed yet; run `flexros blind run"):
        read_answers(made / "logs", made / "truth")


def test_folder_without_cases_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"the folder '{tmp_path}' holds no cases"):
        case_folders(tmp_path)


def test_file_that_is_no_case_is_named(tmp_path: Path) -> None:
    (tmp_path / "case_0000").mkdir()
    (tmp_path / "case_0000" / "case.json").write_text("{}")
    with pytest.raises(InputError, match="case.json' is not a file of a blind check"):
        diagnose_case(tmp_path / "case_0000")
