"""Robot files from an MJCF, against MuJoCo."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_patched
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.robot.exchange.mjcf.robot_import import robot_from_mjcf
from tests.robot.exchange.mjcf.arm_mjcf import ARM

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")


def written(folder: Path, text: str, name: str = "arm.xml") -> Path:
    file = folder / name
    file.write_text(text)
    return file


def one_link(inside: str = "", after: str = "", joint: str = '<joint name="j" axis="0 1 0"/>') -> str:
    return (
        f'<mujoco><worldbody><body name="link">{joint}<geom size=".1" pos=".2 0 0"/>{inside}</body>'
        f'<body name="wall" pos="1 0 0"><geom size=".1"/></body></worldbody>{after}</mujoco>'
    )


def compare_dynamics(file: Path, tmp_path: Path, end: str = "") -> None:
    imported = robot_from_mjcf(file, end)
    robot = load_robot(written(tmp_path, imported.text, "imported.yaml"))
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    sign = np.array([joint.sign for joint in imported.joints])
    reference = np.array([joint.reference for joint in imported.joints])
    n, parameters, rng = model.nv, robot.model.parameter_values, np.random.default_rng(0)
    for moving in (0.0, 1.0, 1.0, 1.0):
        q, v = rng.uniform(-1.5, 1.5, n), moving * rng.normal(size=n)
        data.qpos[:], data.qvel[:] = reference + sign * q, sign * v
        mujoco.mj_forward(model, data)
        theirs = np.zeros((n, n))
        mujoco.mj_fullM(model, data, theirs)
        theirs = sign[:, None] * theirs * sign
        ours = np.array(robot.model.mass_matrix(q, parameters))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * np.abs(theirs).max())
        force = np.array(robot.model.force(q, v, np.zeros(robot.n_motors), np.zeros(6), parameters)).ravel()
        bias = sign * (data.qfrc_bias - data.qfrc_passive)
        np.testing.assert_allclose(-force, bias, rtol=0, atol=1e-9 * np.abs(bias).max())


def test_mass_matrix_bias_and_gravity_are_those_of_mujoco(tmp_path: Path) -> None:
    compare_dynamics(written(tmp_path, ARM), tmp_path)


def test_a_servo_without_damping_has_none(tmp_path: Path) -> None:
    text = one_link(after='<actuator><position joint="j" kp="5"/></actuator>')
    imported = robot_from_mjcf(written(tmp_path, text)).text
    assert "servo: {stiffness: 5.0, damping: 0.0}" in imported
    assert "-0.0" not in imported


SLANTED = """<mujoco><compiler angle="radian"/><worldbody><body name="a">
  <joint axis="0 0 1"/><inertial pos="0 .1 .2" mass="2" diaginertia=".02 .01 .015"/>
  <body pos=".1 0 .3" euler=".2 .5 0"><joint name="b" axis="0 -1 .4" armature=".05"/>
    <inertial pos=".2 .05 0" mass="1" diaginertia=".01 .02 .03"/>
    <body pos=".3 .1 0"><joint type="slide" axis="1 1 0"/><inertial pos=".1 0 0" mass="1" diaginertia=".01 .02 .02"/>
      <body pos=".2 0 .1"><joint axis="1 0 1"/><inertial pos="0 .1 0" mass=".5" diaginertia=".004 .003 .002"/></body>
</body></body></body></worldbody></mujoco>"""


def test_slanted_axes_turn_the_frames_of_bodies(tmp_path: Path) -> None:
    compare_dynamics(written(tmp_path, SLANTED), tmp_path)
    robot = load_robot(tmp_path / "imported.yaml")
    assert [any(body.orientation) for body in robot.spec.bodies] == [False, True, True, True]
    again = written(tmp_path, export_model(load_patched(tmp_path / "imported.yaml"), "mjcf").text, "exported.xml")
    compare_dynamics(again, tmp_path)


def test_joints_against_their_axes_are_in_the_tags(tmp_path: Path) -> None:
    imported = robot_from_mjcf(written(tmp_path, SLANTED))
    tags = load_robot(written(tmp_path, imported.text, "imported.yaml")).spec.tags
    signs = [int(tags.get(f"motor_{k}.joint_sign", "1")) for k in (1, 2, 3, 4)]
    assert signs == [joint.sign for joint in imported.joints]
    assert -1 in signs


def test_base_that_is_turned_gives_a_frame_along_the_axes(tmp_path: Path) -> None:
    file = written(
        tmp_path,
        ARM.replace('euler="90 0 0">\n      <geom type="cylinder"', 'euler="20 30 40">\n<geom type="cylinder"'),
    )
    compare_dynamics(file, tmp_path)
    assert "turned by" in robot_from_mjcf(file).text


def test_numbers_of_joints_and_actuators(tmp_path: Path) -> None:
    imported = robot_from_mjcf(written(tmp_path, ARM))
    robot = load_robot(written(tmp_path, imported.text, "imported.yaml"))
    first, second = robot.motors[0], robot.motors[1]
    assert (first.inertia, first.specification.viscous_friction.value) == (0.05, 1.5)
    assert (first.torque_limit, first.gear_ratio, second.torque_limit) == (50.0, 10.0, 80.0)
    assert second.specification.servo is not None
    assert (second.specification.servo.stiffness.value, second.specification.servo.damping.value) == (500.0, 20.0)
    assert first.specification.servo is None
    assert robot.spec.sample_time.value == 0.001
    assert robot.spec.tags["motor_5.joint"] == "s5"
    assert robot.arm_names[-1] == "body_6.rx"
    assert robot.parameters["body_6.rx.stiffness"].value == 20.0
    assert [(effect.location, effect.value, effect.unit) for effect in imported.effects] == [
        ("motor_1", 2.0, "Nm"),
        ("motor_4", 0.4, "Nm"),
        ("motor_5", 0.4, "N"),
    ]
    assert {effect.effect for effect in imported.effects} == {"coulomb_friction"}
    assert {(each.location, each.name) for each in imported.not_held} == {
        ("motor_1", "gear times gain"),
        ("motor_4", "kv"),
    }
    assert [(joint.sign, round(joint.reference, 6)) for joint in imported.joints][1] == (-1, 0.174533)


def test_joints_are_motors_where_none_has_an_actuator(tmp_path: Path) -> None:
    robot = load_robot(written(tmp_path, robot_from_mjcf(written(tmp_path, one_link())).text, "imported.yaml"))
    assert robot.joint_names == ("motor_1",)


def test_fingers_move_with_the_arm_that_is_named_by_its_end(tmp_path: Path) -> None:
    fingers = "".join(
        f'<body name="finger_{side}"><joint name="f_{side}" axis="0 0 1"/><geom size=".02" pos=".3 {y} 0"/></body>'
        for side, y in (("left", 0.1), ("right", -0.1))
    )
    file = written(tmp_path, one_link(fingers))
    with pytest.raises(InputError, match=r"finger_left, finger_right") as caught:
        robot_from_mjcf(file)
    assert caught.value.argument == "end"
    imported = robot_from_mjcf(file, "link")
    assert [each.location for each in imported.not_held] == ["f_left", "f_right"]
    robot = load_robot(written(tmp_path, imported.text, "imported.yaml"))
    model = mujoco.MjModel.from_xml_path(str(file))
    assert robot.spec.bodies[0].mass.value == pytest.approx(float(model.body_subtreemass[1]))


def test_delay_and_lag_of_actuators(tmp_path: Path) -> None:
    pytest.importorskip("mujoco", minversion="3.5")
    after = '<actuator><general joint="j" dyntype="filter" dynprm="0.02" delay="0.004" nsample="2"/></actuator>'
    imported = robot_from_mjcf(written(tmp_path, one_link(after=after)))
    assert [(each.effect, each.value) for each in imported.effects] == [("actuator_lag", 0.02)]
    assert load_robot(written(tmp_path, imported.text, "imported.yaml")).delay == 0.004


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (one_link(joint='<freejoint name="loose"/>'), "a free joint"),
        (one_link(joint='<joint name="b" type="ball"/>'), "a ball joint"),
        (one_link(after='<equality><connect body1="link" body2="wall" anchor=".2 0 0"/></equality>'), "closes a chain"),
        (one_link(joint=""), "no joint"),
        ("<robot/>", "import-urdf"),
        ("<mujoco><worldbody><body/></mujoco>", "MuJoCo refuses"),
    ],
)
def test_what_is_not_supported_is_refused(text: str, named: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=named):
        robot_from_mjcf(written(tmp_path, text))


SHAPES = """<mujoco><compiler meshdir="assets"/><asset><mesh name="shell" file="shell.obj"/>
<texture name="paint" type="2d" file="paint.png"/><material name="red" texture="paint"/></asset><worldbody>
<body name="link"><joint name="j" axis="0 1 0"/>{inertial}
<geom name="skin" type="mesh" mesh="shell" material="red"{more}/></body></worldbody>
<contact><exclude body1="world" body2="link"/></contact></mujoco>"""
INERTIAL = '<inertial pos=".2 0 0" mass="2" diaginertia=".1 .1 .1"/>'


@pytest.mark.parametrize(
    ("inertial", "more"), [(INERTIAL, ""), ("<geom size='.1' pos='.2 0 0'/>", ' mass="0"')], ids=["stated", "no mass"]
)
def test_missing_meshes_and_pictures_do_not_matter_where_inertia_is_known(
    inertial: str, more: str, tmp_path: Path
) -> None:
    imported = robot_from_mjcf(written(tmp_path, SHAPES.format(inertial=inertial, more=more)))
    plain = f"<mujoco><worldbody><body name='link'><joint name='j' axis='0 1 0'/>{inertial}</body></worldbody></mujoco>"
    assert imported.text == robot_from_mjcf(written(tmp_path, plain)).text


def test_mesh_that_gives_a_body_its_inertia_must_be_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="inertia of body 'link' comes from mesh 'shell', whose file is missing"):
        robot_from_mjcf(written(tmp_path, SHAPES.format(inertial="", more="")))


def test_mesh_of_a_body_that_stands_still_may_be_missing(tmp_path: Path) -> None:
    standing = SHAPES.format(inertial="", more="").replace('<joint name="j" axis="0 1 0"/>', "")
    moving = f'<body name="arm"><joint name="j" axis="0 1 0"/>{INERTIAL}</body></body></worldbody>'
    file = written(tmp_path, standing.replace("</body></worldbody>", moving))
    assert robot_from_mjcf(file).joints[0].joint == "j"


def test_mesh_that_is_there_is_used(tmp_path: Path) -> None:
    (tmp_path / "assets").mkdir()
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    written(tmp_path / "assets", corners, "shell.obj")
    file = written(tmp_path, SHAPES.format(inertial="", more=""))
    robot = load_robot(written(tmp_path, robot_from_mjcf(file).text, "imported.yaml"))
    mass = float(np.array(robot.model.mass_matrix([0.0], robot.model.parameter_values))[0, 0])
    assert mass > 1.0  # a sixth of a cubic metre of 1000 kg/m^3, turned about a corner


def test_inactive_equality_and_those_beside_the_arm_are_allowed(tmp_path: Path) -> None:
    after = '<equality><connect body1="link" body2="wall" anchor=".2 0 0" active="false"/></equality>'
    assert robot_from_mjcf(written(tmp_path, one_link(after=after))).joints[0].joint == "j"


FINGER = '<body name="{}"><joint type="slide"/><geom size=".01"/></body>'


def test_body_before_the_fingers_is_proposed_as_the_end(tmp_path: Path) -> None:
    gripper = FINGER.format("left") + FINGER.format("right")
    with pytest.raises(InputError, match=r"left, right,.* perhaps 'link', where they part"):
        robot_from_mjcf(written(tmp_path, one_link(inside=gripper)))
    loose = one_link(inside=gripper, joint="<freejoint/>")
    with pytest.raises(InputError, match=r"left, right,.* the end of the arm$"):
        robot_from_mjcf(written(tmp_path, loose))


def test_unknown_end_body_lists_the_bodies(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"link, wall") as caught:
        robot_from_mjcf(written(tmp_path, one_link()), "hand")
    assert caught.value.argument == "end"


def test_missing_mujoco_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(InputError, match=r"flexros\[mujoco\]"):
        robot_from_mjcf(written(tmp_path, one_link()))


@pytest.mark.parametrize("name", ["elbow", "six_axis", "two_mass"])
def test_an_exported_robot_comes_back_with_its_elastic_gears(name: str, tmp_path: Path) -> None:
    before = load_patched(name)
    file = written(tmp_path, export_model(before, "mjcf").text)
    imported = robot_from_mjcf(file)
    robot = load_robot(written(tmp_path, imported.text, "imported.yaml"))
    assert [motor.flexible for motor in robot.motors] == [motor.flexible for motor in before.base.motors]
    assert imported.not_held == ()
    rng, n = np.random.default_rng(1), robot.n_coordinates
    for _ in range(3):
        q, v, u = rng.uniform(-0.1, 0.1, n), rng.normal(size=n), rng.normal(size=robot.n_motors)
        ours, theirs = (
            np.asarray(each.model.acceleration(q, v, u, np.zeros(6), each.model.parameter_values)).ravel()
            for each in (before.base, robot)
        )
        np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-8 * np.abs(ours).max())


def test_gravity_that_is_switched_off_is_none(tmp_path: Path) -> None:
    text = one_link().replace("<mujoco>", '<mujoco><option><flag gravity="disable"/></option>')
    robot = load_robot(written(tmp_path, robot_from_mjcf(written(tmp_path, text)).text, "imported.yaml"))
    assert robot.parameters["gravity.z"].value == 0.0


BALANCED = ARM.replace("<body ", '<body gravcomp="{}" ')


def test_an_arm_whose_whole_weight_is_balanced_has_no_gravity(tmp_path: Path) -> None:
    file = written(tmp_path, BALANCED.format(*[1] * BALANCED.count("{}")))
    compare_dynamics(file, tmp_path)
    imported = robot_from_mjcf(file)
    assert "gravity: [0.0, 0.0, 0.0]" in imported.text
    assert "gravcomp" not in {each.name for each in imported.not_held}
    assert [note.split(",")[0] for note in imported.notes] == ["all bodies have gravcomp 1"]


@pytest.mark.parametrize("share", [0.5, 1])
def test_a_weight_that_is_balanced_in_part_names_the_effect_that_states_it(share: float, tmp_path: Path) -> None:
    file = written(tmp_path, ARM.replace('<body name="fore"', f'<body name="fore" gravcomp="{share}"'))
    imported = robot_from_mjcf(file)
    (lost,) = (each for each in imported.not_held if each.name == "gravcomp")
    assert lost.location == "fore"
    assert lost.reason.endswith(f"gravity_error at body_4, relative -{share:g}")
    assert imported.notes == ()
    written(tmp_path, imported.text, "arm.yaml")
    effect = f"  - {{effect: gravity_error, location: body_4, parameters: {{relative: -{share}}}}}\n"
    patch = written(tmp_path, f"robot: arm.yaml\neffects:\n{effect}", "patch.yaml")
    exported = export_model(load_patched(patch), "mjcf", file)
    assert "gravcomp" not in " ".join(each.place for each in exported.written)


def test_bodies_of_one_axis_that_are_balanced_differently_are_listed(tmp_path: Path) -> None:
    file = written(tmp_path, ARM.replace('<body name="hand"', '<body name="hand" gravcomp="1"').replace("rail", "r"))
    (lost,) = (each for each in robot_from_mjcf(file).not_held if each.name == "gravcomp")
    assert "the same gravcomp" in lost.reason


def test_an_actuator_that_integrates_a_speed_is_no_servo(tmp_path: Path) -> None:
    text = one_link(after='<actuator><intvelocity joint="j" kp="5" actrange="-3 3"/></actuator>')
    assert "servo:" not in robot_from_mjcf(written(tmp_path, text)).text


def test_lengths_of_a_drawing_are_known_better_than_masses(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(robot_from_mjcf(written(tmp_path, ARM)).text)
    parameters = load_robot(tmp_path / "robot.yaml").parameters
    assert (parameters["body_1.mass"].tolerance, parameters["body_1.length.z"].tolerance) == (0.03, 0.003)
