"""Position actuators of an MJCF: read as servos, and written back with repaired gains."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_patched
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.robot.exchange.mjcf.actuator_repair import ActuatorRepair
from flexros.robot.exchange.mjcf.actuators import joint_actuator
from flexros.robot.exchange.mjcf.robot_import import robot_from_mjcf
from flexros.robot.exchange.numbers import Export
from flexros.robot.exchange.xml_text import XmlText
from flexros.robot.parameters import SERVO

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

ARM = """<mujoco model="arm">
  <worldbody>
    <body name="link">
      <joint name="j" axis="0 1 0" armature="0.1" damping="0.5"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.3" size="0.03"/>
    </body>
  </worldbody>
  <actuator>{actuator}</actuator>
</mujoco>
"""
POSITION = '<position name="a" joint="j" kp="100" kv="5"/>'
GENERAL = '<general name="a" joint="j" gainprm="100" biastype="affine" biasprm="0 -100 -5"/>'
SOFTER = "effects:\n  - {effect: servo_stiffness_error, location: motor_1, parameters: {relative: -0.2}}\n"


def written(folder: Path, actuator: str, template: str = ARM, end: str = "") -> Path:
    base = folder / "arm.xml"
    base.write_text(template.format(actuator=actuator))
    (folder / "arm.yaml").write_text(robot_from_mjcf(base, end).text)
    return base


def gains(folder: Path, actuator: str) -> tuple[float, float] | None:
    written(folder, actuator)
    parameters = load_robot(folder / "arm.yaml").parameters
    names = [f"motor_1.{SERVO}{key}" for key in ("stiffness", "damping")]
    return (parameters[names[0]].value, parameters[names[1]].value) if names[0] in parameters else None


def repaired(folder: Path, actuator: str, effects: str = SOFTER, template: str = ARM, end: str = "") -> Export:
    base = written(folder, actuator, template, end)
    (folder / "patch.yaml").write_text(f"robot: arm.yaml\n{effects}")
    return export_model(load_patched(folder / "patch.yaml"), "mjcf", base, end=end)


def test_gains_are_on_the_joint_side(tmp_path: Path) -> None:
    assert gains(tmp_path, POSITION) == (100.0, 5.0)
    assert gains(tmp_path, '<position joint="j" kp="100" kv="5" gear="3"/>') == (pytest.approx(900), pytest.approx(45))


def test_general_actuators_count_where_the_control_is_the_position(tmp_path: Path) -> None:
    servo = '<general joint="j" gainprm="80" biastype="affine" biasprm="0 -80 -2"/>'
    assert gains(tmp_path, servo) == (80.0, 2.0)
    assert gains(tmp_path, servo.replace('gainprm="80"', 'gainprm="40"')) is None
    assert gains(tmp_path, '<velocity joint="j" kv="5"/>') is None
    assert gains(tmp_path, '<motor joint="j"/>') is None


@pytest.mark.parametrize("actuator", [POSITION, GENERAL])
def test_repaired_gains_are_written_back(actuator: str, tmp_path: Path) -> None:
    exported = repaired(tmp_path, actuator)
    model = mujoco.MjModel.from_xml_string(exported.text)
    assert model.actuator_gainprm[0, 0] == pytest.approx(80.0)
    assert model.actuator_biasprm[0, :3] == pytest.approx([0.0, -80.0, -5.0])
    (one,) = exported.written
    assert (one.quantity, one.before, one.value, one.unit) == ("servo stiffness", 100.0, pytest.approx(80.0), "Nm/rad")
    assert exported.not_held == ()


def test_a_constant_torque_of_a_servo_stays_with_new_gains(tmp_path: Path) -> None:
    exported = repaired(tmp_path, GENERAL.replace("0 -100 -5", "3 -100 -5"))
    model = mujoco.MjModel.from_xml_string(exported.text)
    assert model.actuator_biasprm[0, :3] == pytest.approx([3.0, -80.0, -5.0])


def test_a_torque_constant_scales_gains_and_limit_of_a_servo(tmp_path: Path) -> None:
    stronger = SOFTER.replace("servo_stiffness_error", "torque_gain_error").replace("-0.2", "0.5")
    exported = repaired(tmp_path, POSITION.replace("/>", ' forcerange="-4 4"/>'), stronger)
    model = mujoco.MjModel.from_xml_string(exported.text)
    assert model.actuator_gainprm[0, 0] == pytest.approx(150.0)
    assert model.actuator_forcerange[0] == pytest.approx([-6.0, 6.0])


@pytest.mark.parametrize(
    "actuator",
    [
        POSITION.replace("/>", ' timeconst="0.1"/>'),
        GENERAL.replace("/>", ' dyntype="filter" dynprm="0.1"/>'),
    ],
)
def test_a_lag_that_a_robot_file_does_not_hold_is_taken_out_with_the_gains(actuator: str, tmp_path: Path) -> None:
    exported = repaired(tmp_path, actuator)
    found = joint_actuator(mujoco.MjModel.from_xml_string(exported.text), 0)
    assert found is not None
    assert found.time_constant == 0
    assert [(one.quantity, one.before, one.value) for one in exported.written][-1] == ("lag of the control", 0.1, 0.0)
    untouched = repaired(tmp_path, actuator, "effects: []\n")
    assert "lag of the control" not in [one.quantity for one in untouched.written]


@pytest.mark.parametrize("actuator", [POSITION, GENERAL, POSITION.replace("/>", ' timeconst="0.1"/>')])
def test_a_filter_of_the_commands_that_was_found_is_written(actuator: str, tmp_path: Path) -> None:
    lag = "effects:\n  - {effect: servo_command_lag, location: motor_1, parameters: {time_constant: 0.03}}\n"
    exported = repaired(tmp_path, actuator, lag)
    found = joint_actuator(mujoco.MjModel.from_xml_string(exported.text), 0)
    assert found is not None
    assert (found.time_constant, found.kp, found.kv) == (pytest.approx(0.03), 100.0, 5.0)
    assert [(one.quantity, one.value) for one in exported.written] == [("lag of the control", 0.03)]
    assert exported.not_held == ()
    patched = load_patched(tmp_path / "patch.yaml")
    new = joint_actuator(mujoco.MjModel.from_xml_string(export_model(patched, "mjcf").text), 0)
    assert new is not None
    assert new.time_constant == pytest.approx(0.03)
    assert json.loads(export_model(patched, "json").text)["joints"][0]["servo_lag"] == pytest.approx(0.03)
    assert "lag of the control" in {one.name for one in export_model(patched, "urdf").not_held}


def test_right_gains_are_left_as_they_are(tmp_path: Path) -> None:
    exported = repaired(tmp_path, POSITION, "effects: []\n")
    assert exported.text == ARM.format(actuator=POSITION)


RATIO = ARM.replace("<worldbody>", '<default><position kp="100" dampratio="1"/></default><worldbody>')
ARMATURE = "effects:\n  - {effect: motor_inertia_error, location: motor_1, parameters: {relative: 0.5}}\n"
HEAVIER = "effects:\n  - {effect: payload_error, location: tool, parameters: {relative: 0.2}}\n"


def damping_of(text: str) -> float:
    return -float(mujoco.MjModel.from_xml_string(text).actuator_biasprm[0, 2])


@pytest.mark.parametrize("effects", [SOFTER, ARMATURE, HEAVIER], ids=["stiffness", "armature", "mass"])
@pytest.mark.parametrize(
    ("template", "actuator"),
    [
        (RATIO, '<position name="a" joint="j"/>'),
        (ARM, '<position name="a" joint="j" kp="100" dampratio="1"/>'),
    ],
    ids=["class", "element"],
)
def test_damping_by_a_ratio_stays_what_the_patch_says(
    template: str, actuator: str, effects: str, tmp_path: Path
) -> None:
    exported = repaired(tmp_path, actuator, effects, template)
    before = damping_of(template.format(actuator=actuator))
    assert damping_of(exported.text) == pytest.approx(before, rel=1e-9)
    (row,) = (one for one in exported.written if one.quantity == "servo damping")
    assert (row.location, row.before, row.value) == ("motor_1", pytest.approx(before), pytest.approx(before))
    assert exported.not_held == ()


def test_damping_by_a_ratio_of_a_general_actuator_stays(tmp_path: Path) -> None:
    actuator = '<general name="a" joint="j" gainprm="100" biastype="affine" biasprm="0 -100 1"/>'
    exported = repaired(tmp_path, actuator, ARMATURE)
    assert damping_of(exported.text) == pytest.approx(damping_of(ARM.format(actuator=actuator)), rel=1e-9)


@pytest.mark.parametrize("template", [RATIO, ARM], ids=["class", "element"])
def test_a_torque_constant_scales_damping_by_a_ratio(template: str, tmp_path: Path) -> None:
    stronger = SOFTER.replace("servo_stiffness_error", "torque_gain_error").replace("-0.2", "0.5")
    actuator = '<position name="a" joint="j" kp="100" dampratio="1"/>'
    exported = repaired(tmp_path, actuator, stronger, template)
    assert damping_of(exported.text) == pytest.approx(1.5 * damping_of(template.format(actuator=actuator)))


def test_damping_by_a_ratio_of_a_joint_beside_the_arm_stays(tmp_path: Path) -> None:
    finger = '<body name="f"><joint name="f" axis="1 0 0"/><geom size=".02" pos="0 0 .4"/></body></body>'
    template = RATIO.replace("    </body>", f"    {finger}")
    actuator = '<position name="a" joint="j" kv="5"/><position name="grip" joint="f"/>'
    exported = repaired(tmp_path, actuator, HEAVIER, template, end="link")
    before, after = (
        mujoco.MjModel.from_xml_string(text) for text in (template.format(actuator=actuator), exported.text)
    )
    assert after.body_mass[2] == pytest.approx(1.2 * before.body_mass[2])
    assert after.actuator_biasprm[1, 2] == pytest.approx(before.actuator_biasprm[1, 2], rel=1e-9)
    assert "grip" in {one.location for one in exported.written}


def test_gains_that_the_file_makes_otherwise_are_refused(tmp_path: Path) -> None:
    base = written(tmp_path, POSITION)
    text = XmlText(base.read_text(), "arm.xml")
    repair = ActuatorRepair(mujoco.MjModel.from_xml_path(str(base)), text.root, "arm.xml", [], [])
    other = mujoco.MjModel.from_xml_string(base.read_text().replace('kv="5"', 'kv="6"'))
    with pytest.raises(InputError, match="biasprm of actuator 'a'"):
        repair.check(other)


def test_foreign_actuators_are_listed(tmp_path: Path) -> None:
    repaired(tmp_path, POSITION)
    base = written(tmp_path, POSITION)
    base.write_text(ARM.format(actuator='<motor name="a" joint="j"/>'))
    exported = export_model(load_patched(tmp_path / "patch.yaml"), "mjcf", base)
    assert [one.name for one in exported.not_held] == ["servo stiffness", "servo damping"]


def test_new_files_have_position_actuators(tmp_path: Path) -> None:
    repaired(tmp_path, POSITION)
    model = mujoco.MjModel.from_xml_string(export_model(load_patched(tmp_path / "patch.yaml"), "mjcf").text)
    assert model.actuator_gainprm[0, 0] == pytest.approx(80.0)
    assert model.actuator_biasprm[0, 2] == pytest.approx(-5.0)


def test_other_formats_hold_or_list_the_gains(tmp_path: Path) -> None:
    repaired(tmp_path, POSITION)
    patched = load_patched(tmp_path / "patch.yaml")
    content = json.loads(export_model(patched, "json").text)
    assert content["joints"][0]["servo_stiffness"] == pytest.approx(80.0)
    assert content["joints"][0]["units"]["servo_damping"] == "Nm s/rad"
    assert list(content["isaac_lab"]["stiffness"].values()) == [pytest.approx(80.0)]
    lost = {one.name for one in export_model(patched, "urdf").not_held}
    assert {"servo stiffness", "servo damping"} <= lost
    without = json.loads(export_model(load_patched("elbow"), "json").text)
    assert "servo_stiffness" not in without["joints"][0]
    assert "stiffness" not in without["isaac_lab"]
