from __future__ import annotations

import json
import shutil
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot.robot import LIBRARY
from flexros.view import shown as shown_module
from flexros.view.shown import is_diagnosis, is_log, shown_diagnosis, shown_log

if TYPE_CHECKING:
    from pathlib import Path

PATCH = """robot: e12
effects:
  - effect: coulomb_friction
    location: motor_1
    parameters: {level: 2000.0}
"""


@pytest.fixture
def diagnosis(circle: Path, tmp_path: Path) -> Path:
    folder = tmp_path / "answer"
    folder.mkdir()
    content = {"provenance": {"log": "circle_fj", "robot": "e12"}}
    (folder / "diagnosis.json").write_text(json.dumps(content))
    (folder / "patch.yaml").write_text(PATCH)
    shutil.copytree(circle, tmp_path / "circle_fj")
    return folder


def test_path_of_a_log_has_the_error_of_its_analysis(circle: Path) -> None:
    shown = shown_log(circle)
    assert shown.path is not None
    assert np.linalg.norm(shown.path.deviation, axis=1).max() == pytest.approx(2.1e-3, rel=0.05)
    assert np.ptp(shown.path.commanded[:, 0]) == pytest.approx(0.05, rel=0.05)


def test_diagnosis_shows_robot_nominal_and_repaired_model(diagnosis: Path) -> None:
    shown = shown_diagnosis(diagnosis)
    assert [arm.name for arm in shown.arms] == ["robot", "nominal model", "repaired model"]
    assert len({arm.colour for arm in shown.arms}) == 3
    robot, nominal, repaired = (arm.arm for arm in shown.arms)
    nominal_off, repaired_off = (np.nanmax(np.abs(model - robot)) for model in (nominal, repaired))
    assert repaired_off > 1.5 * nominal_off, "this patch adds a friction that the robot does not have"


def test_nominal_model_is_the_robot_file_that_the_patch_names(diagnosis: Path) -> None:
    """The name in diagnosis.json is that within the file, which may be anywhere."""
    text = (LIBRARY / "e12.yaml").read_text()
    (diagnosis.parent / "cell.yaml").write_text(text.replace("name: e12", "name: cell_3", 1))
    content = {"provenance": {"log": "circle_fj", "robot": "cell_3"}}
    (diagnosis / "diagnosis.json").write_text(json.dumps(content))
    (diagnosis / "patch.yaml").write_text(PATCH.replace("robot: e12", "robot: ../cell.yaml"))
    shown = shown_diagnosis(diagnosis)
    assert shown.robot.name == "cell_3"
    assert len(shown.arms) == 3
    (diagnosis / "patch.yaml").unlink()
    with pytest.raises(InputError, match="'cell_3'; give its file") as error:
        shown_diagnosis(diagnosis)
    assert error.value.argument == "model"
    assert len(shown_diagnosis(diagnosis, model=str(diagnosis.parent / "cell.yaml")).arms) == 2


def test_model_that_cannot_predict_is_left_out_with_a_sentence(
    diagnosis: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    predict = shown_module.predicted_motion

    def refuse(*given: object, name: str, **more: object) -> object:
        if name == "nominal model":
            raise InputError("the prediction of e12 runs away")
        return predict(*given, name=name, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(shown_module, "predicted_motion", refuse)
    shown = shown_diagnosis(diagnosis)
    assert [arm.name for arm in shown.arms] == ["robot", "repaired model"]
    assert "The nominal model is not drawn: the prediction of e12 runs away." in shown.text


def test_log_of_a_diagnosis_that_is_nowhere_is_named(diagnosis: Path) -> None:
    shutil.rmtree(diagnosis.parent / "circle_fj")
    with pytest.raises(InputError, match="'circle_fj'") as error:
        shown_diagnosis(diagnosis)
    assert error.value.argument == "log"


def test_folder_that_is_no_diagnosis_is_refused(tmp_path: Path) -> None:
    (tmp_path / "diagnosis.json").write_text("{}")
    with pytest.raises(InputError, match="no diagnosis"):
        shown_diagnosis(tmp_path)


def test_kinds_are_told_apart(diagnosis: Path, circle: Path) -> None:
    assert is_diagnosis(diagnosis)
    assert not is_diagnosis(circle)
    assert is_log(circle)
    assert not is_log(diagnosis.parent / "robot.yaml")


def test_log_without_a_robot_asks_for_one(circle: Path, tmp_path: Path) -> None:
    copy = tmp_path / "bare"
    shutil.copytree(circle, copy)
    (copy / "provenance.json").unlink()
    with pytest.raises(InputError) as error:
        shown_log(copy)
    assert error.value.argument == "model"
