"""A user's own MJCF as the base of an export: which of its joints the motors of a robot are, and how they count."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flexros.robot.exchange.joint_names import all_turned_round, motor_joints
from flexros.robot.exchange.mjcf.arm import MjcfArm, find_arm
from flexros.robot.exchange.mjcf.mujoco_model import compile_file

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class MjcfBase:
    """A user's MJCF, with the joints that the motors of a robot are.

    Attributes:
        path: The file.
        model: Its compiled model (mujoco.MjModel).
        arm: The arm in it.
        names: Its joint by motor.
        turned: Motors and arm coordinates of the robot that count the other way round than their joints.
    """

    path: Path
    model: Any
    arm: MjcfArm
    names: Mapping[str, str]
    turned: frozenset[str]


def mjcf_base(path: Path, robot: Robot, joints: Mapping[str, str], end: str = "") -> MjcfBase:
    """Read a user's MJCF and find the motors of a robot in it.

    Args:
        path: The MJCF.
        robot: The robot.
        joints: Joint of the file by motor; default: as in `motor_joints`.
        end: Body at the end of the arm; default: the only possible one.

    Raises:
        InputError: MuJoCo is missing or refuses the file, or it is not clear which joint is meant.
    """
    model = compile_file(path)
    arm = find_arm(model, str(path), end)
    names = motor_joints(robot, [joint.name for joint in arm.joints], joints, str(path))
    signs = {joint.name: joint.sign for joint in arm.joints}
    springs = all_turned_round(robot).difference(robot.joint_names)
    return MjcfBase(path, model, arm, names, springs.union(motor for motor in names if signs[names[motor]] < 0))
