"""Which joint of a bag is which motor of the model, and which way it counts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.robot import Robot

Found = Literal["name", "end of the name", "order"]


@dataclass(frozen=True)
class JointMatch:
    """A joint of the bag as a motor.

    Attributes:
        motor: Name of the motor.
        joint: Name in the bag.
        sign: -1 where the joint counts against the motor.
        found: How it was found.
    """

    motor: str
    joint: str
    sign: Literal[1, -1]
    found: Found


def match_joints(robot: Robot | None, joints: Sequence[str], bag: str) -> tuple[JointMatch, ...]:
    """Match the motors of a robot to the joints of a bag: by name, by the end of a prefixed name, else by order.

    Args:
        robot: The model; one made from a URDF has the names of its joints as tags. None: each joint is a motor.
        joints: Joints of the bag.
        bag: The bag, for error messages.

    Raises:
        InputError: It is not clear which joint is a motor.
    """
    if robot is None:
        return tuple(JointMatch(f"motor_{k}", joint, 1, "order") for k, joint in enumerate(joints, start=1))
    tags = robot.spec.tags
    wanted = {motor: tags.get(f"{motor}.joint", motor) for motor in robot.joint_names}
    signs: dict[str, Literal[1, -1]] = {
        motor: -1 if tags.get(f"{motor}.joint_sign") == "-1" else 1 for motor in robot.joint_names
    }
    matches = []
    for motor, name in wanted.items():
        ends = [joint for joint in joints if joint.endswith(name) and joint[-len(name) - 1 : -len(name)] in ("_", "/")]
        if name in joints:
            matches.append(JointMatch(motor, name, signs[motor], "name"))
        elif len(ends) == 1:
            matches.append(JointMatch(motor, ends[0], signs[motor], "end of the name"))
    if len(matches) == robot.n_motors:
        return tuple(matches)
    if not matches and len(joints) == robot.n_motors:
        return tuple(JointMatch(motor, joint, signs[motor], "order") for motor, joint in zip(robot.joint_names, joints))
    missing = ", ".join(name for motor, name in wanted.items() if motor not in {match.motor for match in matches})
    raise InputError(
        f"{bag} has the joints {', '.join(joints)}, and none of them is {missing} of robot {robot.name}; give the "
        "model of the robot in the bag, or write a mapping file"
    )
