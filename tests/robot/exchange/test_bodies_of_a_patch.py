"""Numbers of bodies that a patch holds: a new file has them, and a URDF of the user."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import PatchedRobot, load_patched
from flexros.robot import Robot, load_robot
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


def imported(text: str, folder: Path) -> Robot:
    """Return the robot of a URDF."""
    (folder / "repaired.urdf").write_text(text)
    (folder / "repaired.yaml").write_text(robot_from_urdf(folder / "repaired.urdf").text)
    return load_robot(str(folder / "repaired.yaml"))


@pytest.mark.parametrize("body", ["body_2", "body_3", "body_5", "body_7"])
def test_a_file_of_the_user_gets_the_difference(body: str, tmp_path: Path) -> None:
    """Read again, it has the numbers of the patch: the frames of its links are turned against those of the bodies."""
    (tmp_path / "ur5e.yaml").write_text(robot_from_urdf(URDF).text)
    change = "mass: {value: 0.25}, y: {value: -0.02}, zz: {value: 2e-5}, xy: {value: 1e-5}, x"
    (tmp_path / "patch.yaml").write_text(PATCH.replace("body_3", body).replace("mass: {value: -0.25}, x", change))
    patched = load_patched(str(tmp_path / "patch.yaml"))
    exported = export_model(patched, "urdf", URDF)
    found, wanted = imported(exported.text, tmp_path).parameters, patched.model.robot.parameters
    names = [name for name in wanted if name.startswith("body_")]
    assert [found[name].value for name in names] == pytest.approx([wanted[name].value for name in names], abs=1e-9)
    assert not any(each.location == body for each in exported.not_held)
    (mass,) = (each for each in exported.written if each.quantity == "mass")
    assert (mass.location, mass.value - (mass.before or 0.0)) == (body, pytest.approx(0.25))


def test_numbers_that_a_link_cannot_have_are_listed(tmp_path: Path) -> None:
    """In the file of the user a tool of its own is most of the body: without it nothing would be left of the link."""
    (tmp_path / "ur5e.yaml").write_text(robot_from_urdf(URDF).text)
    (tmp_path / "patch.yaml").write_text(PATCH)
    base = tmp_path / "light.urdf"
    base.write_text(
        re.sub(r'(<link name="upper_arm_link">.*?<mass value=")[^"]+', r"\g<1>0.1", URDF.read_text(), flags=re.DOTALL)
    )
    exported = export_model(load_patched(str(tmp_path / "patch.yaml")), "urdf", base)
    (lost,) = (each for each in exported.not_held if each.location == "body_3")
    assert "the link upper_arm_link cannot have them" in lost.reason
    assert not exported.written


def test_an_sdf_of_the_user_keeps_its_own_and_the_others_are_listed(patched: PatchedRobot, tmp_path: Path) -> None:
    base = tmp_path / "base.sdf"
    base.write_text(export_model(load_patched(str(tmp_path / "ur5e.yaml")), "sdf").text)
    exported = export_model(patched, "sdf", base)
    (lost,) = (each for each in exported.not_held if each.location == "body_3")
    assert (lost.name, f"mass {mass_of(patched):.6g} kg" in lost.size) == ("numbers", True)
    assert "an export without a base file has these" in lost.reason
    assert not exported.written


def test_a_load_and_a_difference_of_the_same_body_are_written_together(tmp_path: Path) -> None:
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
    found, wanted = imported(exported.text, tmp_path).parameters, patched.model.robot.parameters
    assert found["body_7.mass"].value == pytest.approx(wanted["body_7.mass"].value)
    assert found["body_7.inertia.zz"].value == pytest.approx(wanted["body_7.inertia.zz"].value)
    assert not any(each.location == "body_7" for each in exported.not_held)
