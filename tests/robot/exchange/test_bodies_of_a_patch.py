"""Numbers of bodies that a patch holds: a new file has them, a file of the user keeps its own."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import PatchedRobot, load_patched
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf

URDF = Path(__file__).parents[3] / "docs" / "examples" / "ur5e.urdf"
PATCH = """
robot: ur5e.yaml
effects:
  - effect: body_difference
    location: body_3
    parameters: {mass: {value: -0.25}, x: {value: 0.01}}
"""


@pytest.fixture
def patched(tmp_path: Path) -> PatchedRobot:
    (tmp_path / "ur5e.yaml").write_text(robot_from_urdf(URDF).text)
    (tmp_path / "patch.yaml").write_text(PATCH)
    return load_patched(str(tmp_path / "patch.yaml"))


def mass_of(robot: PatchedRobot) -> float:
    return robot.model.robot.parameters["body_3.mass"].value


def test_a_new_file_has_them(patched: PatchedRobot) -> None:
    exported = export_model(patched, "urdf")
    masses = [float(value) for value in re.findall(r'<mass value="([^"]+)"', exported.text)]
    assert mass_of(patched) == pytest.approx(patched.base.parameters["body_3.mass"].value - 0.25)
    assert any(mass == pytest.approx(mass_of(patched)) for mass in masses)
    assert not any(each.location == "body_3" for each in exported.not_held)


def test_a_file_of_the_user_keeps_its_own_and_the_others_are_listed(patched: PatchedRobot) -> None:
    exported = export_model(patched, "urdf", URDF)
    (lost,) = (each for each in exported.not_held if each.location == "body_3")
    assert lost.name == "numbers"
    assert f"mass {mass_of(patched):.6g} kg" in lost.size
    assert "an export without a base file has these" in lost.reason
    assert not exported.written


def test_a_load_is_written_beside_a_difference_of_the_same_body(tmp_path: Path) -> None:
    """Only the difference is listed: the documents promise the load in the last link."""
    (tmp_path / "ur5e.yaml").write_text(robot_from_urdf(URDF).text)
    (tmp_path / "patch.yaml").write_text(
        """
robot: ur5e.yaml
effects:
  - effect: tool_load
    location: tool
    parameters: {mass: {value: 1.3}, z: {value: 0.2}}
  - effect: body_difference
    location: body_7
    parameters: {zz: {value: 4.4e-5}}
"""
    )
    patched = load_patched(str(tmp_path / "patch.yaml"))
    exported = export_model(patched, "urdf", URDF)
    (load,) = (each for each in exported.written if each.location == "body_7")
    assert "load of 1.3 kg" in load.quantity
    assert load.value == pytest.approx(patched.model.robot.parameters["body_7.mass"].value)
    (lost,) = (each for each in exported.not_held if each.location == "body_7")
    assert (lost.name, lost.size) == ("numbers", "inertia zz +4.4e-05 kg m2")
