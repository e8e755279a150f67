"""A user's own MJCF with repaired numbers: right in the compiled model, and nothing else changed in the text."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml

from flexros.effects.base_tilt import BaseTilt
from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_patched
from flexros.errors import InputError
from flexros.robot import robot_from_data
from flexros.robot.exchange.mjcf.robot_import import robot_from_mjcf
from flexros.robot.exchange.numbers import Export
from tests.robot.exchange.mjcf.arm_mjcf import ARM

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

FRICTION = (
    "  - {effect: coulomb_friction, location: motor_1, parameters: {level: 2}}\n"
    "  - {effect: coulomb_friction, location: motor_4, parameters: {level: 0.4}}\n"
    "  - {effect: coulomb_friction, location: motor_5, parameters: {level: 0.4}}\n"
)
"""What the MJCF has already."""

Repair = Callable[..., Export]


@pytest.fixture
def repair(tmp_path: Path) -> Repair:
    def repaired(effects: str, text: str = ARM, **options: object) -> Export:
        base, robot, patch = tmp_path / "arm.xml", tmp_path / "arm.yaml", tmp_path / "patch.yaml"
        base.write_text(ARM)
        robot.write_text(robot_from_mjcf(base).text)
        base.write_text(text)
        patch.write_text(f"robot: arm.yaml\neffects:\n{FRICTION}{effects}")
        return export_model(load_patched(patch), "mjcf", base, **options)  # type: ignore[arg-type]

    return repaired


def changed_lines(text: str) -> list[str]:
    lines = difflib.unified_diff(ARM.splitlines(), text.splitlines(), lineterm="", n=0)
    return [line[1:].strip() for line in lines if line.startswith("+") and not line.startswith("+++")]


def test_nothing_changes_without_a_difference(repair: Repair) -> None:
    exported = repair("")
    assert exported.text == ARM
    assert exported.written == exported.not_held == ()


def test_only_the_attributes_that_differ_are_changed(repair: Repair) -> None:
    exported = repair(
        "  - {effect: coulomb_friction, location: motor_1, parameters: {level: 0.5}}\n"
        "  - {effect: viscous_friction, location: motor_2, parameters: {coefficient: 0.5}}\n"
        "  - {effect: motor_inertia_error, location: motor_3, parameters: {relative: 0.5}}\n"
        "  - {effect: stiffness_error, location: body_6.rx, parameters: {relative: 0.2}}\n"
    )
    assert changed_lines(exported.text) == [
        'frictionloss="2.5"/>  <!-- measured -->',
        '<joint name="j2" axis="0 0 -1" pos="0.01 0.02 0.03" ref="10" damping="2"/>',
        '<joint name="j3" axis="0 0 1" armature="0.075"/>',
        '<joint name="spring6" axis="0 1 0" stiffness="24" armature="0"/>',
    ]
    assert [(row.location, row.quantity, row.before, row.unit) for row in exported.written] == [
        ("motor_1", "dry friction", 2.0, "Nm"),
        ("motor_2", "viscous friction", 1.5, "Nm s/rad"),
        ("motor_3", "rotor inertia", 0.05, "kg m2"),
        ("body_6.rx", "stiffness", 20.0, "Nm/rad"),
    ]


def test_gains_limit_and_delay_of_actuators(repair: Repair) -> None:
    exported = repair(
        "  - {effect: torque_gain_error, location: motor_1, parameters: {relative: -0.1}}\n"
        "  - {effect: torque_gain_error, location: motor_2, parameters: {relative: 0.1}}\n"
        "  - {effect: torque_gain_error, location: motor_4, parameters: {relative: 0.5}}\n"
        "  - {effect: torque_saturation, location: motor_1, parameters: {limit: 30}}\n"
    )
    model = mujoco.MjModel.from_xml_string(exported.text)
    assert model.actuator_gear[0, 0] == 9
    assert model.actuator_forcerange[0] == pytest.approx([-3, 3])
    assert model.actuator_gainprm[1, 0] == 550
    assert model.actuator_biasprm[1, :3] == pytest.approx([0, -550, -22])
    assert model.actuator_biasprm[3, :3] == pytest.approx([0, 0, -4.5])


def test_delay_of_an_actuator(repair: Repair) -> None:
    pytest.importorskip("mujoco", minversion="3.5")
    exported = repair("  - {effect: delay, location: motor_1, parameters: {time: 0.0042}}\n")
    model = mujoco.MjModel.from_xml_string(exported.text)
    assert model.actuator_delay[0] == 0.0042
    assert model.actuator_history[0, 0] == 5
    assert 'interp="linear"' in exported.text


def test_payload_and_weight(repair: Repair) -> None:
    exported = repair(
        "  - {effect: payload_error, location: tool, parameters: {relative: 0.2}}\n"
        "  - {effect: gravity_error, location: body_4, parameters: {relative: 0.1}}\n"
    )
    before, after = mujoco.MjModel.from_xml_string(ARM), mujoco.MjModel.from_xml_string(exported.text)
    flap = before.body("flap").id
    assert after.body_mass[flap] == pytest.approx(1.2 * before.body_mass[flap])
    np.testing.assert_allclose(after.body_inertia[flap], 1.2 * before.body_inertia[flap])
    np.testing.assert_allclose(np.delete(after.body_mass, flap), np.delete(before.body_mass, flap))
    assert after.body_gravcomp[after.body("fore").id] == pytest.approx(-0.1)


@pytest.mark.parametrize("text", [ARM, ARM.replace('ref="10"', 'stiffness="5" ref="10" springref="20"')])
def test_another_zero_of_an_encoder_turns_the_bodies_and_moves_no_spring(text: str, repair: Repair) -> None:
    exported = repair("  - {effect: encoder_offset, location: motor_2, parameters: {offset: 0.1}}\n", text)
    before, after = (mujoco.MjModel.from_xml_string(each) for each in (text, exported.text))
    found = []
    for model, shown in ((before, 0.3), (after, 0.3 - 0.1)):  # the axis of j2 is against that of the robot file
        data = mujoco.MjData(model)
        data.qpos[:] = [0.2, shown, 0.4, 0.5, 0.01, 0.1]
        mujoco.mj_forward(model, data)
        found.append((data.xpos.copy(), data.qfrc_spring.copy()))
    for nominal, repaired in zip(*found, strict=True):
        np.testing.assert_allclose(repaired, nominal, atol=1e-12)
    assert next(row.place for row in exported.written if row.location == "motor_2") == "joint j2 ref"
    assert exported.not_held == ()


def test_what_is_listed_counts_as_the_joint_of_the_file_for_a_robot_without_tags_too(tmp_path: Path) -> None:
    base, robot, patch = tmp_path / "arm.xml", tmp_path / "arm.yaml", tmp_path / "patch.yaml"
    base.write_text(ARM)
    content = yaml.safe_load(robot_from_mjcf(base).text)
    tags = content.pop("tags")
    joints = {f"motor_{k}": tags[f"motor_{k}.joint"] for k in range(1, 6)}
    robot.write_text(yaml.safe_dump(content))
    bias = "{effect: torque_bias, location: motor_2, parameters: {level: 0.26}}"
    patch.write_text(f"robot: arm.yaml\neffects: [{bias}]\n")
    listed = {row.name: row.size for row in export_model(load_patched(patch), "mjcf", base, joints).not_held}
    assert listed["torque_bias"] == "level -0.26 Nm"  # the axis of j2 is against that of the robot file


LOAD = "  - {effect: tool_load, location: tool, parameters: {mass: 2, x: 0.05, y: -0.04, z: 0.1}}\n"
DIFFERENCE = "  - {{effect: body_difference, location: {}, parameters: {{mass: {}, x: {}}}}}\n"
INERTIA = "  - {effect: inertia_error, location: body_5, parameters: {relative: 0.3}}\n"
HEAVIER = INERTIA.replace("body_5", "body_6") + (
    "  - {effect: payload_error, location: tool, parameters: {relative: 0.2}}\n"
)
TURNED = ARM.replace('euler="90 0 0">', 'euler="20 30 40">')


@pytest.mark.parametrize("text", [ARM, TURNED], ids=["along the axes", "turned"])
@pytest.mark.parametrize(
    ("effect", "rows"),
    [
        (LOAD, 10),
        (DIFFERENCE.format("body_2", 0.5, 0.01), 4),
        (DIFFERENCE.format("body_5", 0.1, 0.001), 10),
        (INERTIA, 6),
        (HEAVIER, 7),
    ],
)
def test_loads_and_numbers_of_bodies_move_the_arm_as_they_do_the_robot(
    effect: str, rows: int, text: str, tmp_path: Path
) -> None:
    base, patch = tmp_path / "arm.xml", tmp_path / "patch.yaml"
    base.write_text(text)
    imported = robot_from_mjcf(base)
    (tmp_path / "arm.yaml").write_text(imported.text)
    patch.write_text(f"robot: arm.yaml\neffects:\n{FRICTION}{effect}")
    patched = load_patched(patch)
    exported = export_model(patched, "mjcf", base)
    assert (len(exported.written), exported.not_held) == (rows, ())
    model, robot = mujoco.MjModel.from_xml_string(exported.text), patched.model.robot
    data, sign = mujoco.MjData(model), np.array([joint.sign for joint in imported.joints])
    q, v = np.linspace(-1, 1.3, model.nv), np.linspace(2, -1, model.nv)
    data.qpos[:] = np.array([joint.reference for joint in imported.joints]) + sign * q
    data.qvel[:] = sign * v
    mujoco.mj_forward(model, data)
    theirs = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, theirs)
    theirs, parameters = sign[:, None] * theirs * sign, robot.model.parameter_values
    ours = np.array(robot.model.mass_matrix(q, parameters))
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-8 * np.abs(ours).max())
    force = np.array(robot.model.force(q, v, np.zeros(robot.n_motors), np.zeros(6), parameters)).ravel()
    bias = sign * (data.qfrc_bias - data.qfrc_passive)
    np.testing.assert_allclose(bias, -force, rtol=0, atol=1e-8 * np.abs(force).max())


def test_a_load_on_a_file_with_other_axes_is_listed_with_its_frame(repair: Repair) -> None:
    exported = repair(LOAD, ARM.replace('name="spring6" axis="0 1 0"', 'name="spring6" axis="1 0 0"'))
    (lost,) = exported.not_held
    assert "0.05, -0.04, 0.1 m from its joint, along the axes of the base at zero pose" in lost.size


def test_a_difference_that_leaves_no_mass_for_the_body_of_the_joint_is_listed(repair: Repair) -> None:
    exported = repair(DIFFERENCE.format("body_5", -0.6, 0.01))
    assert [each.name for each in exported.not_held] == ["numbers"]


def test_what_mjcf_has_no_place_for_is_listed(repair: Repair) -> None:
    exported = repair(
        "  - {effect: torque_ripple, location: motor_1, parameters: {amplitude: 0.5, order: 3}}\n"
        "  - {effect: coulomb_friction, location: motor_2, parameters: {level: 0.3, asymmetry: 0.2}}\n"
        "  - {effect: stribeck_friction, location: motor_3, parameters: {extra: 1.5, velocity: 0.1}}\n"
    )
    rows = {(row.location, row.name): row.size for row in exported.not_held}
    assert "amplitude 0.5 Nm" in rows["motor_1", "torque_ripple"]
    assert "asymmetry -0.2" in rows["motor_2", "coulomb_friction"]  # its joint counts the other way round
    assert "extra 1.5" in rows["motor_3", "stribeck_friction"]
    assert [row.location for row in exported.written] == ["motor_2"]


def test_inertia_of_an_actuator_counts(repair: Repair) -> None:
    if not hasattr(mujoco.MjModel.from_xml_string(ARM), "actuator_armature"):
        pytest.skip("this MuJoCo has no inertia of actuators")
    text = ARM.replace('ctrlrange="-5 5"', 'ctrlrange="-5 5" armature="0.0002"')
    exported = repair("  - {effect: motor_inertia_error, location: motor_1, parameters: {relative: 1}}\n", text)
    model = mujoco.MjModel.from_xml_string(exported.text)
    assert model.dof_armature[0] + 100 * model.actuator_armature[0] == pytest.approx(0.1)


@pytest.mark.parametrize("option", ['gravity="0 0 -9.81"', "", None])
def test_gravity_of_a_slanted_base_is_read_again(option: str | None, repair: Repair, tmp_path: Path) -> None:
    whole = '<option timestep="0.001" gravity="0 0 -9.81"/>'
    text = ARM.replace(whole, "" if option is None else f'<option timestep="0.001" {option}/>')
    exported = repair("  - {effect: base_tilt, location: base, parameters: {x: 0.02, y: -0.03}}\n", text)
    assert {row.quantity for row in exported.written} == {"gravity x", "gravity y", "gravity z"}
    assert exported.not_held == ()
    slanted, upright = (
        tmp_path / "slanted.xml",
        robot_from_data(yaml.safe_load((tmp_path / "arm.yaml").read_text()), ""),
    )
    slanted.write_text(exported.text)
    found = robot_from_data(yaml.safe_load(robot_from_mjcf(slanted).text), "")
    wanted = BaseTilt(x=0.02, y=-0.03).changed(upright, "base")
    np.testing.assert_allclose(found.spec.gravity.value, wanted.spec.gravity.value, atol=1e-9)


def test_joints_are_given_by_name(repair: Repair) -> None:
    text = ARM.replace('"j1"', '"turn"')
    with pytest.raises(InputError, match=r"motor_1") as caught:
        repair("", text)
    assert caught.value.argument == "joint"
    effect = "  - {effect: coulomb_friction, location: motor_1, parameters: {level: 0.5}}\n"
    assert 'frictionloss="2.5"' in repair(effect, text, joints={"motor_1": "turn"}).text
    with pytest.raises(InputError, match="did you mean 'turn'"):
        repair("", text, joints={"motor_1": "turm"})


def test_a_base_in_several_files_is_refused(repair: Repair, tmp_path: Path) -> None:
    inner = ARM[ARM.index("<worldbody>") : ARM.index("</worldbody>") + len("</worldbody>")]
    (tmp_path / "inner.xml").write_text(f"<mujocoinclude>{inner}</mujocoinclude>")
    with pytest.raises(InputError, match="file itself"):
        repair("", ARM.replace(inner, '<include file="inner.xml"/>'))


def test_springdamper_is_refused(repair: Repair) -> None:
    text = ARM.replace('name="j3"', 'name="j3" springdamper="0.1 1"')
    with pytest.raises(InputError, match="springdamper"):
        repair("", text)


def test_a_setting_that_overrides_the_numbers_is_named(repair: Repair) -> None:
    text = ARM.replace('autolimits="true"', 'autolimits="true" inertiafromgeom="true"')
    with pytest.raises(InputError, match="inertiafromgeom"):
        repair("  - {effect: payload_error, location: tool, parameters: {relative: 0.2}}\n", text)


def test_motor_side_numbers_are_right_in_joint_units(tmp_path: Path) -> None:
    """MuJoCo with the user's joint and its gear moves as the robot whose file states all on the motor side."""
    robot, patch, base = tmp_path / "axis.yaml", tmp_path / "patch.yaml", tmp_path / "axis.xml"
    robot.write_text(
        "name: axis\ncoordinates: motor\nsample_time: 0.001\nbodies:\n"
        "  - inertia: {zz: 2.0e-4}\n    directions:\n"
        "      rz: {spring: rigid, motor: {inertia: 3.0e-4, viscous_friction: 1.0e-3, gear_ratio: 50}}\n"
        "outputs: {joints: {coordinates: [body_1.rz]}}\ncontrolled: joints\n"
        "tool: {linear: {divisor: 50, weights: {body_1.rz: 1}}}\n"
    )
    patch.write_text(
        "robot: axis.yaml\neffects:\n"
        "  - {effect: coulomb_friction, location: motor_1, parameters: {level: 0.02}}\n"
        "  - {effect: viscous_friction, location: motor_1, parameters: {coefficient: 1.0e-3}}\n"
        "  - {effect: torque_gain_error, location: motor_1, parameters: {relative: 0.2}}\n"
    )
    base.write_text(
        '<mujoco><option timestep="0.001" integrator="RK4"/><worldbody><body><inertial pos="0 0 0" mass="1" '
        'diaginertia="0.5 0.5 0.5"/><joint name="waist" axis="0 0 1"/></body></worldbody>'
        '<actuator><motor joint="waist" gear="50"/></actuator></mujoco>'
    )
    model = mujoco.MjModel.from_xml_string(export_model(load_patched(patch), "mjcf", base).text)
    data, torque, duration = mujoco.MjData(model), 0.1, 0.4
    for _ in range(round(duration / model.opt.timestep)):
        data.ctrl[:] = torque
        mujoco.mj_step(model, data)
    rate, final = 2e-3 / 5e-4, (1.2 * torque - 0.02) / 2e-3
    motor_speed = final * (1 - np.exp(-rate * duration))
    assert 50 * data.qvel[0] == pytest.approx(motor_speed, rel=1e-3)


def test_meshes_are_found_from_the_folder_of_the_base(repair: Repair, tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (tmp_path / "meshes" / "tip.obj").write_text(corners)
    text = ARM.replace('eulerseq="zyx"', 'eulerseq="zyx" meshdir="meshes"').replace(
        "<worldbody>", '<asset><mesh name="tip" file="tip.obj"/></asset><worldbody><geom type="mesh" mesh="tip"/>'
    )
    effect = "  - {effect: coulomb_friction, location: motor_1, parameters: {level: 0.5}}\n"
    assert 'frictionloss="2.5"' in repair(effect, text).text


def test_assets_beside_the_base_are_found(repair: Repair, tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text("<mujocoinclude><asset><material name='steel'/></asset></mujocoinclude>")
    text = ARM.replace("<worldbody>", '<include file="scene.xml"/><worldbody>')
    effect = "  - {effect: coulomb_friction, location: motor_1, parameters: {level: 0.5}}\n"
    assert 'frictionloss="2.5"' in repair(effect, text).text


def test_elastic_gears_and_payload_of_an_exported_robot(tmp_path: Path) -> None:
    base, patch = tmp_path / "elbow.xml", tmp_path / "patch.yaml"
    base.write_text(export_model(load_patched("elbow"), "mjcf").text)
    patch.write_text(
        "robot: elbow\neffects:\n"
        "  - {effect: payload_error, location: tool, parameters: {relative: 0.2}}\n"
        "  - {effect: stiffness_error, location: body_1.ry, parameters: {relative: -0.1}}\n"
        "  - {effect: damping_error, location: body_1.ry, parameters: {relative: 0.5}}\n"
        "  - {effect: coulomb_friction, location: motor_1, parameters: {level: 12}}\n"
    )
    exported = export_model(load_patched(patch), "mjcf", base)
    assert {(row.location, row.quantity): row.value for row in exported.written} == {
        ("motor_1", "dry friction"): 12,
        ("body_1.ry", "stiffness"): 1.8e5,
        ("body_1.ry", "damping"): 180,
        ("body_2", "mass"): pytest.approx(54),
        ("body_2", "inertia"): pytest.approx(3.6),
    }
    new = mujoco.MjModel.from_xml_string(export_model(load_patched(patch), "mjcf").text)
    repaired = mujoco.MjModel.from_xml_string(exported.text)
    for array in ("dof_damping", "dof_frictionloss", "dof_armature", "jnt_stiffness", "body_mass"):
        np.testing.assert_allclose(getattr(repaired, array), getattr(new, array), err_msg=array)
