"""Loading robots, robot files and patches."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from flexros.effects import PlacedEffect, parse_effect, place_effects
from flexros.effects.patching.patched_robot import load_model, load_patched
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.robot.robot import LIBRARY


def write(path: Path, robot: str, *effects: str, **keys: Any) -> Path:
    entries = [_entry(parse_effect(text, "test")) for text in effects]
    path.write_text(json.dumps({"robot": robot, "effects": entries, **keys}), encoding="utf-8")
    return path


def _entry(placed: PlacedEffect) -> dict[str, Any]:
    parameters = placed.effect.model_dump(mode="json", exclude_defaults=True)
    return {"effect": placed.effect.name, "location": placed.location, "parameters": parameters}


def test_a_robot_is_a_model_without_laws() -> None:
    model = load_model("e12")
    assert model.robot.model_hash == load_robot("e12").model_hash == load_patched("e12").fingerprint
    assert model.laws == ()


def test_a_patch_equals_its_effects_on_the_robot(tmp_path: Path) -> None:
    texts = ("payload_error@tool:relative=0.05", "coulomb_friction@motor_2:level=30")
    model = load_model(write(tmp_path / "patch.yaml", "e12", *texts))
    expected = place_effects(load_robot("e12"), [parse_effect(text, "test") for text in texts])
    assert model.robot.model_hash == expected.robot.model_hash
    assert model.laws == expected.laws


def test_patch_on_a_patch_adds_up(tmp_path: Path) -> None:
    write(tmp_path / "one.yaml", "e12", "payload_error@tool:relative=0.1")
    second = write(tmp_path / "two.yaml", "one.yaml", "payload_error@tool:relative=0.1")
    assert load_model(second).robot.parameters["body_3.mass"].value == pytest.approx(242.0)


def test_robot_file_is_found_next_to_the_patch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.yaml").write_text((LIBRARY / "two_mass.yaml").read_text())
    patch = write(tmp_path / "patch.yaml", "mine.yaml", "coulomb_friction@motor_1:level=1")
    monkeypatch.chdir(LIBRARY)
    assert load_model(patch).robot.name == "two_mass"


def test_changed_base_is_refused_with_advice(tmp_path: Path) -> None:
    base = tmp_path / "mine.yaml"
    base.write_text((LIBRARY / "e12.yaml").read_text())
    effect = "payload_error@tool:relative=0.05"
    patch = write(tmp_path / "patch.yaml", "mine.yaml", effect, robot_hash=load_patched(base).fingerprint)
    assert load_model(patch).robot.parameters["body_3.mass"].value == pytest.approx(210.0)
    base.write_text(base.read_text().replace("mass: 200", "mass: 190"))
    with pytest.raises(InputError, match=r"patch\.yaml, key robot_hash: .* robot mine\.yaml .* file has changed"):
        load_model(patch)


def test_hash_of_a_patch_below_counts_its_effects(tmp_path: Path) -> None:
    below = write(tmp_path / "one.yaml", "e12", "payload_error@tool:relative=0.1")
    above = write(tmp_path / "two.yaml", "one.yaml", "delay@all:time=0.001", robot_hash=load_patched(below).fingerprint)
    load_model(above)
    write(tmp_path / "one.yaml", "e12", "payload_error@tool:relative=0.2")
    with pytest.raises(InputError, match="robot_hash"):
        load_model(above)


@pytest.mark.parametrize(
    ("robot", "effect", "message"),
    [
        (
            "e13",
            "payload_error@tool:relative=0.1",
            r"patch\.yaml, key robot: unknown robot 'e13'.*did you mean 'e12'\?",
        ),
        ("gone.yaml", "payload_error@tool:relative=0.1", r"patch\.yaml, key robot: cannot read .*gone\.yaml"),
        (
            "e12",
            "coulomb_friction@motor_7:level=1",
            r"patch\.yaml: unknown location of coulomb_friction on robot e12 'motor_7'.*motor_1, motor_2",
        ),
        (
            "patch.yaml",
            "payload_error@tool:relative=0.1",
            r"patch\.yaml: the patch is circular",
        ),
    ],
)
def test_incompatible_patch_is_refused_with_one_sentence(tmp_path: Path, robot: str, effect: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        load_model(write(tmp_path / "patch.yaml", robot, effect))
    assert "\n" not in str(caught.value)


def test_values_change_the_robot_below_the_effects(tmp_path: Path) -> None:
    patched = load_patched(write(tmp_path / "patch.yaml", "e12", "payload_error@tool:relative=0.1"))
    changed = patched.with_values({"body_3.mass": 100.0}, "test")
    assert changed.model.robot.parameters["body_3.mass"].value == pytest.approx(110.0)
    assert changed.fingerprint != patched.fingerprint
