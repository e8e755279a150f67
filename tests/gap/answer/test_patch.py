"""The patch that a diagnosis writes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.effects.patching.patched_robot import load_model, load_patched
from flexros.errors import InputError
from flexros.gap.answer.patch import patch_of, write_patch
from flexros.gap.prediction.predicted_log import PredictedLog
from flexros.gap.result import DiagnosisResult, Explanation
from flexros.gap.schema import Cause, CauseParameter, Diagnosis, GapNumbers
from flexros.record.record import Record
from flexros.robot import load_robot
from flexros.robot.robot import LIBRARY

LEVEL = CauseParameter(value=25.0, std=0.25, unit="Nm")
RIPPLES = ("torque_ripple@motor_1:amplitude=1,order=2", "torque_ripple@motor_1:amplitude=0.5,order=6")


def cause(effect: str, location: str, **parameters: CauseParameter) -> Cause:
    return Cause(effect=effect, location=location, probability=0.9, parameters=parameters, closed_fraction=0.99)


TOO_ALIKE = 0.01 * np.array([[1.0, 1.0 + 1e-5], [1.0 + 1e-5, 1.0]])
"""Two parameters of which rounding left a correlation above 1."""


def result(causes: tuple[Cause, ...], texts: tuple[str, ...], **numbers: float) -> DiagnosisResult:
    """Diagnosis of e12 with effects and variances by full name."""
    nothing = np.zeros((10, 2))
    diagnosis = Diagnosis(
        schema=2,
        verdict="explained" if causes else "no_gap",
        causes=causes,
        ambiguity_groups=(),
        where=(),
        gap=GapNumbers(metric="prediction error", unit="1", before=2.0, noise_floor=1.0),
        next_experiment=None,
        warnings=(),
        provenance={},
    )
    return DiagnosisResult(
        diagnosis=diagnosis,
        robot=load_robot("e12"),
        record=Record("bags/monday", 5e-4, nothing, nothing, np.ones(10, dtype=np.bool_)),
        holdout=None,
        before=Explanation("nominal", PredictedLog(nothing, np.ones(2))),
        patch=tuple(parse_effect(text, "test") for text in texts),
        covariance_of=tuple(numbers),
        covariance=np.diag(list(numbers.values())) if numbers else None,
    )


def friction() -> DiagnosisResult:
    name = "coulomb_friction@motor_1.level"
    return result(
        (cause("coulomb_friction", "motor_1", level=LEVEL),),
        ("coulomb_friction@motor_1:level=25",),
        **{name: 0.0625, "body_1.ry.stiffness": 4.0},
    )


def test_patch_read_back_is_the_robot_with_the_found_effects(tmp_path: Path) -> None:
    found = friction()
    write_patch(found, "e12", tmp_path / "patch.yaml")
    expected = place_effects(load_robot("e12"), found.patch)
    model = load_model(tmp_path / "patch.yaml")
    assert model.laws == expected.laws
    assert model.robot.model_hash == expected.robot.model_hash


def test_patch_states_value_deviation_unit_covariance_and_origin(tmp_path: Path) -> None:
    patch = patch_of(friction(), "e12", tmp_path)
    assert patch.effects[0].parameters["level"].model_dump() == {"value": 25.0, "std": 0.25, "unit": "Nm"}
    assert patch.source == "diagnosis of bags/monday: explained"
    assert patch.robot_hash == load_robot("e12").model_hash


def test_numbers_within_tolerance_have_no_part_in_the_covariance(tmp_path: Path) -> None:
    covariance = patch_of(friction(), "e12", tmp_path).covariance
    assert covariance is not None
    assert covariance.model_dump() == {"names": ("coulomb_friction@motor_1.level",), "matrix": ((0.0625,),)}


def test_unknown_deviations_are_left_out(tmp_path: Path) -> None:
    endless = LEVEL.model_copy(update={"std": float("inf")})
    found = result(
        (cause("coulomb_friction", "motor_1").model_copy(update={"parameters": {"level": endless}}),),
        ("coulomb_friction@motor_1:level=25",),
        **{"coulomb_friction@motor_1.level": float("inf")},
    )
    patch = patch_of(found, "e12", tmp_path)
    assert patch.effects[0].parameters["level"].std is None
    assert patch.covariance is None


def test_two_orders_at_one_motor_stay_apart(tmp_path: Path) -> None:
    causes = tuple(
        cause("torque_ripple", "motor_1", amplitude=CauseParameter(value=size, std=0.1 * size, unit="Nm"))
        for size in (1.0, 0.5)
    )
    names = ("torque_ripple@motor_1.amplitude", "torque_ripple@motor_1#2.amplitude")
    patch = write_patch(result(causes, RIPPLES, **dict.fromkeys(names, 0.01)), "e12", tmp_path / "patch.yaml")
    assert [one.parameters["amplitude"].std for one in patch.effects] == [0.1, 0.05]
    assert [one.parameters["order"].value for one in patch.effects] == [2.0, 6.0]
    assert patch.covariance is not None
    assert patch.covariance.names == names
    assert [law.effect.parameter_values["order"] for law in load_model(tmp_path / "patch.yaml").laws] == [2.0, 6.0]


def test_numbers_that_the_log_hardly_tells_apart_have_a_possible_covariance(tmp_path: Path) -> None:
    causes = tuple(
        cause("torque_ripple", "motor_1", amplitude=CauseParameter(value=size, std=0.1, unit="Nm"))
        for size in (1.0, 0.5)
    )
    names = ("torque_ripple@motor_1.amplitude", "torque_ripple@motor_1#2.amplitude")
    found = replace(result(causes, RIPPLES, **dict.fromkeys(names, 0.01)), covariance=TOO_ALIKE)
    patch = write_patch(found, "e12", tmp_path / "patch.yaml")
    assert patch.covariance is not None
    np.testing.assert_allclose(patch.covariance.matrix, TOO_ALIKE, rtol=2e-5)
    np.testing.assert_allclose(np.diagonal(patch.covariance.matrix), np.diagonal(TOO_ALIKE), rtol=1e-8)
    assert load_model(tmp_path / "patch.yaml").laws


def test_no_gap_gives_a_patch_that_changes_nothing(tmp_path: Path) -> None:
    write_patch(result((), ()), "e12", tmp_path / "patch.yaml")
    assert load_patched(tmp_path / "patch.yaml").fingerprint == load_robot("e12").model_hash


def test_a_robot_file_is_found_from_the_folder_of_the_patch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.yaml").write_text((LIBRARY / "e12.yaml").read_text())
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)
    write_patch(friction(), "mine.yaml", Path("out/patch.yaml"))
    monkeypatch.chdir(LIBRARY)
    assert load_model(tmp_path / "out" / "patch.yaml").laws[0].name == "coulomb_friction@motor_1"


def test_patch_of_a_patch_lies_on_top_of_it(tmp_path: Path) -> None:
    write_patch(friction(), "e12", tmp_path / "one.yaml")
    second = replace(friction(), patch=(parse_effect("payload_error@tool:relative=0.1", "test"),), covariance=None)
    write_patch(second, tmp_path / "one.yaml", tmp_path / "two.yaml")
    model = load_model(tmp_path / "two.yaml")
    assert model.robot.parameters["body_3.mass"].value == pytest.approx(220.0)
    assert [law.name for law in model.laws] == ["coulomb_friction@motor_1"]


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"the patch cannot be written to '.*gone/patch\.yaml'"):
        write_patch(friction(), "e12", tmp_path / "gone" / "patch.yaml")
