"""Robot files from a URDF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.robot.body_placement import BodyPlacements
from flexros.robot.exchange.urdf.export import urdf_text
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf

URDF = """<robot name="little">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 0.3" rpy="0 0 1.5707963267948966"/><mass value="12"/>
    <inertia ixx="0.5" iyy="0.4" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.2 0 0"/><mass value="7"/>
    <inertia ixx="0.1" iyy="0.3" izz="0.3" ixy="0.01" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"><inertial><origin xyz="0 0.01 0"/><mass value="2"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="camera"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.5" rpy="0 0 0"/><axis xyz="0 0 1"/>
    <limit effort="150" velocity="3" lower="-3" upper="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/>
    <origin xyz="0 0 0.6" rpy="0 1.5707963267948966 0"/><axis xyz="0 1 0"/>
    <limit effort="0" velocity="3" lower="-3" upper="3"/></joint>
  <joint name="flange" type="fixed"><parent link="fore"/><child link="hand"/><origin xyz="0.4 0 0"/></joint>
  <joint name="eye" type="fixed"><parent link="upper"/><child link="camera"/></joint>
</robot>
"""


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    file = tmp_path / "little.urdf"
    file.write_text(URDF)
    return file


def test_skeleton_is_a_robot_file_with_the_dynamics_of_the_urdf(urdf: Path, tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed")
    robot_file = tmp_path / "little.yaml"
    robot_file.write_text(robot_from_urdf(urdf).text)
    robot = load_robot(robot_file)
    assert robot.n_arm == 2
    model = pin.buildModelFromXML(URDF)
    data = model.createData()
    rng = np.random.default_rng(0)
    q, v, a = rng.normal(size=2), rng.normal(size=2), rng.normal(size=2)
    ours = np.asarray(robot.model.arm_inverse_dynamics(q, v, a, [])).ravel()
    np.testing.assert_allclose(ours, pin.rnea(model, data, q, v, a), rtol=1e-6)


def test_an_effort_that_means_no_limit_is_none(urdf: Path) -> None:
    """A URDF must state a limit: where there is none, authors and `export` write a million."""
    urdf.write_text(urdf.read_text(encoding="utf-8").replace('effort="150"', 'effort="1e6"'), encoding="utf-8")
    assert "torque_limit" not in robot_from_urdf(urdf).text


def test_torque_limit_and_comment_are_written(urdf: Path) -> None:
    text = robot_from_urdf(urdf).text
    assert "torque_limit: 150.0" in text
    assert "speed_limit: 3.0" in text
    assert "replace by the gear's stiffness" in text


def test_slanted_axis_turns_the_frame_of_its_body(urdf: Path, tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed")
    text = URDF.replace('<axis xyz="0 1 0"/>', '<axis xyz="0.1 1 -0.7"/>')
    urdf.write_text(text)
    robot_file = tmp_path / "little.yaml"
    rng = np.random.default_rng(0)
    for _ in range(2):  # the second time as exported
        robot_file.write_text(robot_from_urdf(urdf).text)
        robot = load_robot(robot_file)
        assert any(robot.spec.bodies[1].orientation)
        model = pin.buildModelFromXML(text)
        q, v, a = rng.normal(size=2), rng.normal(size=2), rng.normal(size=2)
        ours = np.asarray(robot.model.arm_inverse_dynamics(q, v, a, [])).ravel()
        np.testing.assert_allclose(ours, pin.rnea(model, model.createData(), q, v, a), rtol=1e-6)
        urdf.write_text(text := urdf_text(robot).replace("continuous", "revolute"))


def test_orientation_of_the_tool_is_that_of_the_turned_frames(urdf: Path, tmp_path: Path) -> None:
    robot_file = tmp_path / "little.yaml"
    urdf.write_text(URDF.replace('<axis xyz="0 1 0"/>', '<axis xyz="0.1 1 -0.7"/>'))
    robot_file.write_text(robot_from_urdf(urdf).text)
    robot = load_robot(robot_file)
    q = np.array([0.4, -0.9])
    pose = np.asarray(robot.model.tool_pose(q, robot.model.parameter_values)).ravel()
    frame = BodyPlacements(robot).poses(q)[-1]
    assert abs(pose[3:] @ frame[3:]) == pytest.approx(1.0, abs=1e-12)


def test_body_that_does_not_move_is_not_turned(tmp_path: Path, urdf: Path) -> None:
    robot_file = tmp_path / "little.yaml"
    robot_file.write_text(
        robot_from_urdf(urdf).text.replace("- label: hand", "- label: hand\n    orientation: [0.1, 0, 0]")
    )
    with pytest.raises(InputError, match="orientation"):
        load_robot(robot_file)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("not xml", "is not XML"),
        ("<sdf/>", "starts with <sdf>"),
        ("<robot name='a'><link name='b'/></robot>", "no revolute, continuous or prismatic joint"),
        ("<!DOCTYPE r [<!ENTITY a 'b'>]><robot/>", "document type definition"),
    ],
)
def test_what_is_no_urdf_is_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "bad.urdf"
    file.write_text(text)
    with pytest.raises(InputError, match=message):
        robot_from_urdf(file)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', r"joint 'elbow' has the axis \[0.0, 0.0, 0.0\], which has no"),
        (
            '<axis xyz="0 1 0"/>',
            '<axis xyz="0 nan 0"/>',
            "joint 'elbow': xyz of <axis> is '0 nan 0', but must be 3 fin",
        ),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1"/>', "joint 'elbow': xyz of <axis> is '0 1', but must be 3 finite"),
        ('xyz="0 0 0.6"', 'xyz="0 0 ${h}"', "joint 'elbow': xyz of <origin> is '0 0 \\${h}', but must be 3 finite"),
        ('rpy="0 0 0"', 'rpy="0 0"', "joint 'shoulder': rpy of <origin> is '0 0', but must be 3 finite numbers"),
        ('effort="150"', 'effort="much"', "joint 'shoulder': effort of <limit> is 'much', but must be a finite number"),
        ('<mass value="7"/>', '<mass value="7 kg"/>', "link 'fore': value of <mass> is '7 kg', but must be a finite"),
        ('ixy="0.01"', 'ixy="small"', "link 'fore': ixy of <inertia> is 'small', but must be a finite number"),
        (
            '<child link="fore"/>',
            '<child link="four"/>',
            "joint 'elbow' names the child link 'four', but the links are",
        ),
        ('"elbow" type="revolute"', '"elbow" type="Revolute"', "joint 'elbow' has the type 'Revolute', allowed are"),
        ('"elbow" type="revolute"', '"elbow"', "joint 'elbow' has the type '', allowed are"),
        ('"shoulder" type="revolute"', '"shoulder" type="floating"', "joint 'shoulder' is floating, but a robot"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><mimic joint="shoulder"/>', "joint 'elbow' mimics shoulder, but"),
        ('<parent link="upper"/><child link="fore"/>', '<child link="fore"/>', "joint 'elbow' lacks <parent>"),
        ('<parent link="base"/>', '<parent link="hand"/>', "joint '[a-z]+' closes a circle of joints through the link"),
        ('<parent link="base"/>', '<parent link="upper"/>', "joint 'shoulder' closes a circle of joints through"),
        ('<child link="camera"/>', '<child link="hand"/>', "joints 'flange' and 'eye' both carry the link 'hand'"),
    ],
)
def test_wrong_entry_is_named(urdf: Path, old: str, new: str, message: str) -> None:
    assert old in URDF
    urdf.write_text(URDF.replace(old, new, 1))
    with pytest.raises(InputError, match=message):
        robot_from_urdf(urdf)


def test_an_undeclared_base_is_a_link_without_mass(urdf: Path) -> None:
    """As `world`, which some simulators know by its name; another unknown link is a mistake."""
    declared = robot_from_urdf(urdf)
    urdf.write_text(URDF.replace('<link name="base"/>', "").replace('"base"', '"world"'))
    imported = robot_from_urdf(urdf)
    assert imported.text == declared.text
    assert imported.notes == ("the base link world, which the URDF does not declare, is one without mass",)
    assert not declared.notes
    urdf.write_text(URDF.replace('<parent link="base"/>', '<parent link="bass"/>'))
    with pytest.raises(
        InputError, match="joint 'shoulder' names the parent link 'bass', but the links are base, upper"
    ):
        robot_from_urdf(urdf)


@pytest.mark.parametrize(("axis", "turn", "opposite"), [("0 0 -1", "0", True), ("0 0 -1", "3.141592653589793", False)])
def test_axis_that_points_the_other_way_in_the_base_is_remarked(
    urdf: Path, axis: str, turn: str, opposite: bool
) -> None:
    text = URDF.replace('<axis xyz="0 0 1"/>', f'<axis xyz="{axis}"/>', 1)
    urdf.write_text(text.replace('rpy="0 0 0"', f'rpy="{turn} 0 0"', 1))
    assert ("points the other way" in robot_from_urdf(urdf).text.split("label: fore")[0]) is opposite


def test_axis_turned_the_other_way_by_its_frame_is_remarked(urdf: Path) -> None:
    urdf.write_text(URDF.replace('rpy="0 0 0"', 'rpy="3.141592653589793 0 0"', 1))
    assert "points the other way" in robot_from_urdf(urdf).text.split("label: fore")[0]


def test_stiffness_of_a_prismatic_gear_is_asked_for_in_its_unit(urdf: Path) -> None:
    urdf.write_text(URDF.replace('name="elbow" type="revolute"', 'name="elbow" type="prismatic"'))
    assert "replace by the gear's stiffness [N/m]" in robot_from_urdf(urdf).text


def test_long_tail_of_fixed_links_is_no_obstacle(urdf: Path) -> None:
    links = "".join(f'<link name="t{k}"/>' for k in range(3000))
    ends = ["camera", *(f"t{k}" for k in range(3000))]
    joints = "".join(
        f'<joint name="j{k}" type="fixed"><parent link="{ends[k]}"/><child link="t{k}"/></joint>' for k in range(3000)
    )
    urdf.write_text(URDF.replace("</robot>", f"{links}{joints}</robot>"))
    assert "t2999" not in robot_from_urdf(urdf).text


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot read"):
        robot_from_urdf(tmp_path / "none.urdf")


def test_friction_and_names_of_joints_are_kept(tmp_path: Path) -> None:
    file, robot_file = tmp_path / "little.urdf", tmp_path / "little.yaml"
    file.write_text(URDF.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1"/><dynamics damping="4" friction="2"/>'))
    robot_file.write_text(robot_from_urdf(file).text)
    robot = load_robot(robot_file)
    assert robot.motors[0].specification.viscous_friction.value == 4
    assert robot.spec.tags["motor_2.joint"] == "elbow"
    assert "dry friction of 2" in robot_file.read_text()
    (effect,) = robot_from_urdf(file).effects
    assert (effect.effect, effect.location, effect.parameter, effect.value) == (
        "coulomb_friction",
        "motor_1",
        "level",
        2,
    )


GRIPPER = """<link name="left"><inertial><origin xyz="0 0.02 0.03"/><mass value="0.3"/>
    <inertia ixx="1e-4" iyy="2e-4" izz="2e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="right"><inertial><mass value="0.3"/>
    <inertia ixx="1e-4" iyy="2e-4" izz="2e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="left_finger" type="prismatic"><parent link="hand"/><child link="left"/>
    <origin xyz="0.1 0.05 0" rpy="0.3 0 0"/><axis xyz="0 1 0"/>
    <limit effort="9" velocity="1" lower="0" upper="0.05"/></joint>
  <joint name="right_finger" type="prismatic"><parent link="hand"/><child link="right"/>
    <origin xyz="0.1 -0.05 0"/><axis xyz="0 1 0"/>
    <limit effort="9" velocity="1" lower="0" upper="0.05"/></joint>
</robot>"""


def _torques_of(text: str, tmp_path: Path, tip: str, motion: np.ndarray) -> np.ndarray:
    (tmp_path / "arm.urdf").write_text(text)
    (tmp_path / "arm.yaml").write_text(robot_from_urdf(tmp_path / "arm.urdf", tip).text)
    return np.asarray(load_robot(tmp_path / "arm.yaml").model.arm_inverse_dynamics(*motion, [])).ravel()


def test_fingers_of_a_gripper_are_fixed_to_the_tip(tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed")
    text = URDF.replace("</robot>", GRIPPER)
    whole = pin.buildModelFromXML(text)
    fingers = [whole.getJointId(name) for name in ("left_finger", "right_finger")]
    model = pin.buildReducedModel(whole, fingers, pin.neutral(whole))
    motion = np.random.default_rng(0).normal(size=(3, 2))
    expected = pin.rnea(model, model.createData(), *motion)
    np.testing.assert_allclose(_torques_of(text, tmp_path, "hand", motion), expected, rtol=1e-6)


def test_several_chains_ask_for_the_tip(urdf: Path) -> None:
    urdf.write_text(URDF.replace("</robot>", GRIPPER))
    with pytest.raises(InputError, match="left_finger, right_finger") as raised:
        robot_from_urdf(urdf)
    assert raised.value.argument == "tip"
    with pytest.raises(InputError, match="did you mean 'hand'"):
        robot_from_urdf(urdf, "hnd")


@pytest.mark.parametrize(("arm", "tip"), [(URDF, "hand"), ('<robot name="legs"><link name="hand"/></robot>', "left")])
def test_the_tip_that_is_proposed_carries_the_fingers_of_a_gripper(urdf: Path, arm: str, tip: str) -> None:
    """Chains that have more joints than lie before them, such as legs, are arms themselves."""
    urdf.write_text(arm.replace("</robot>", GRIPPER))
    with pytest.raises(InputError, match=f"e.g. '{tip}'"):
        robot_from_urdf(urdf)


def test_base_is_turned_where_the_first_joint_is_slanted(tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed")
    text = URDF.replace('rpy="0 0 0"', 'rpy="0.3 0.4 0.5"', 1)
    model = pin.buildModelFromXML(text)
    motion = np.random.default_rng(0).normal(size=(3, 2))
    expected = pin.rnea(model, model.createData(), *motion)
    np.testing.assert_allclose(_torques_of(text, tmp_path, "", motion), expected, rtol=1e-6)


def test_inertia_that_no_body_has_is_replaced_by_the_nearest(urdf: Path, tmp_path: Path) -> None:
    old = '<inertia ixx="0.5" iyy="0.4" izz="0.1" ixy="0" ixz="0" iyz="0"/>'
    urdf.write_text(URDF.replace(old, old.replace("0.5", "0.7")))
    text = robot_from_urdf(urdf).text
    assert "the nearest one that a body can have" in text
    (tmp_path / "robot.yaml").write_text(text)
    moments = np.linalg.eigvalsh(load_robot(tmp_path / "robot.yaml").spec.bodies[0].inertia.matrix())
    assert moments[2] == pytest.approx(moments[0] + moments[1])
    np.testing.assert_allclose(moments, [0.2, 0.5, 0.7])


@pytest.mark.parametrize("moment", ["0.000", "1000"])
def test_inertia_that_was_rounded_to_zero_or_is_a_placeholder_is_that_of_a_ball(
    moment: str, urdf: Path, tmp_path: Path
) -> None:
    old = '<inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/>'
    urdf.write_text(URDF.replace(old, old.replace("0.02", moment).replace("0.01", moment)))
    (tmp_path / "robot.yaml").write_text(robot_from_urdf(urdf).text)
    radius = (3 * 2 / (4 * np.pi * 2700)) ** (1 / 3)
    inertia = load_robot(tmp_path / "robot.yaml").spec.bodies[2].inertia.matrix()
    np.testing.assert_allclose(inertia, 0.4 * 2 * radius**2 * np.eye(3))


def test_lengths_of_a_drawing_are_known_better_than_masses(urdf: Path, tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(robot_from_urdf(urdf).text.replace("tolerance: 0.03\n", "tolerance: 0.5\n"))
    parameters = load_robot(tmp_path / "robot.yaml").parameters
    assert parameters["body_1.mass"].tolerance == 0.5
    assert {parameters[f"body_1.length.{axis}"].tolerance for axis in "xyz"} == {0.003}
