"""Joint numbers as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_patched
from flexros.errors import InputError


def test_numbers_are_on_the_joint_side_with_units() -> None:
    content = json.loads(export_model(load_patched("four_mass_linear"), "json").text)
    joint = content["joints"][0]
    assert joint["armature"] == pytest.approx(5e-3 * 220**2)
    assert joint["rotor_inertia"] == pytest.approx(5e-3)
    assert joint["stiffness"] == pytest.approx(100 * 220**2)
    assert joint["torque_limit"] == pytest.approx(20 * 220)
    assert (joint["delay"], joint["units"]["damping"]) == (5e-4, "Nm s/rad")
    assert content["springs"][1]["stiffness"] == pytest.approx(110 * 220**2)


def test_gravity_is_that_of_a_slanted_base(tmp_path: Path) -> None:
    patch = tmp_path / "patch.yaml"
    patch.write_text("robot: elbow\neffects:\n  - {effect: base_tilt, location: base, parameters: {x: 0.1}}\n")
    content = json.loads(export_model(load_patched(patch), "json").text)
    assert content["gravity"] == {"value": pytest.approx([0, -0.979366, -9.76099], abs=1e-5), "unit": "m/s2"}


def test_isaac_lab_has_friction_by_joint(tmp_path: Path) -> None:
    patch = tmp_path / "patch.yaml"
    patch.write_text(
        "robot: elbow\neffects:\n  - {effect: coulomb_friction, location: motor_1, parameters: {level: 12}}\n"
    )
    content = json.loads(export_model(load_patched(patch), "json", joints={"motor_1": "shoulder"}).text)
    assert content["isaac_lab"]["friction"] == {"shoulder": 12, "motor_2": 0}
    assert content["isaac_lab"]["viscous_friction"] == {"shoulder": 60, "motor_2": 30}
    assert content["isaac_lab"]["armature"] == {"shoulder": 60, "motor_2": 25}


def test_base_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        export_model(load_patched("elbow"), "json", tmp_path / "a.json")
    assert caught.value.argument == "base"
