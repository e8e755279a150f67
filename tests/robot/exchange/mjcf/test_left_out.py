"""What an import of an MJCF leaves out is named, with its size."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.robot import load_robot
from flexros.robot.exchange.imported import ImportedRobot
from flexros.robot.exchange.mjcf.robot_import import robot_from_mjcf

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

ARM = """<mujoco><compiler angle="radian" autolimits="true"/>{option}<worldbody>
<body name="a"><joint name="j" axis="0 1 0"{joint}/><inertial pos=".1 0 0" mass="1" diaginertia=".01 .02 .02"/>
<body name="b" pos=".3 0 0"><joint name="k" axis="0 1 0" damping="0.1"/>
<inertial pos=".1 0 0" mass=".5" diaginertia=".001 .002 .002"/><site name="s"/></body></body></worldbody>
<actuator>{actuators}</actuator></mujoco>"""


def imported(
    folder: Path, first: str, second: str = '<motor joint="k"/>', joint: str = "", option: str = ""
) -> ImportedRobot:
    file = folder / "arm.xml"
    file.write_text(ARM.format(actuators=first + second, joint=joint, option=option))
    return robot_from_mjcf(file)


def left_out(robot: ImportedRobot) -> list[tuple[str, str, str]]:
    return [(each.location, each.name, each.size) for each in robot.not_held]


@pytest.mark.parametrize(
    ("actuator", "joint", "row"),
    [
        ('<position joint="j" kp="50" kv="2" ctrlrange="-.1 .2"/>', "", ("ctrlrange", "-0.1 to 0.2")),
        ('<motor joint="j" forcerange="-10 30"/>', "", ("forcerange", "-10 to 30 Nm")),
        ('<motor joint="j" ctrlrange="0 5"/>', "", ("ctrlrange", "0 to 5 Nm")),
        ('<motor joint="j" gear="-2" ctrlrange="0 5"/>', "", ("ctrlrange", "-10 to 0 Nm")),
        ('<motor joint="j"/>', ' actuatorfrcrange="-4 3"', ("actuatorfrcrange", "-4 to 3 Nm")),
        ('<damper joint="j" kv="3" ctrlrange="0 1"/>', "", ("gain", "0 per position, -3 per speed")),
    ],
)
def test_ranges_and_gains_that_a_robot_file_lacks_are_named(
    actuator: str, joint: str, row: tuple[str, str], tmp_path: Path
) -> None:
    assert ("motor_1", *row) in left_out(imported(tmp_path, actuator, joint=joint))


def test_even_ranges_are_imported_and_not_named(tmp_path: Path) -> None:
    assert left_out(imported(tmp_path, '<motor joint="j" ctrlrange="-5 5" forcerange="-4 4"/>')) == []


def test_a_constant_torque_is_named_and_the_servo_kept(tmp_path: Path) -> None:
    robot = imported(tmp_path, '<general joint="j" gainprm="50" biastype="affine" biasprm="5 -50 -2"/>')
    assert left_out(robot) == [("motor_1", "constant torque", "5 Nm")]
    assert "servo: {stiffness: 50.0, damping: 2.0}" in robot.text


def test_an_actuator_at_a_site_is_named_with_the_joints_that_it_leaves_free(tmp_path: Path) -> None:
    site = '<motor name="pull" site="s" refsite="s" gear="0 0 0 0 1 0"/>'
    robot = imported(tmp_path, '<motor joint="j"/>', site)
    assert left_out(robot) == [("pull", "actuator", "through a site")]
    assert "turn freely (spring 0): k;" in robot.not_held[0].reason


@pytest.mark.parametrize("flag", ["damper", "frictionloss", "spring"])
def test_what_a_flag_disables_is_not_imported(flag: str, tmp_path: Path) -> None:
    joint = ' damping="3" frictionloss="2" stiffness="20"'
    option = f'<option><flag {flag}="disable"/></option>'
    robot = imported(tmp_path, '<motor joint="j"/>', joint=joint, option=option)
    (tmp_path / "arm.yaml").write_text(robot.text)
    viscous = load_robot(tmp_path / "arm.yaml").motors[0].specification.viscous_friction.value
    assert viscous == (0.0 if flag == "damper" else 3.0)
    assert len(robot.effects) == (0 if flag == "frictionloss" else 1)
    assert ("stiffness" in [each.name for each in robot.not_held]) == (flag != "spring")


def test_actuators_that_an_option_switches_off_are_named(tmp_path: Path) -> None:
    option = '<option actuatorgroupdisable="1"/>'
    robot = imported(tmp_path, '<motor name="m" joint="j" group="1"/>', option=option)
    assert left_out(robot) == [("all", "actuators", "m")]
