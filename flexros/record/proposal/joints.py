"""Which joint of a bag is which motor of the model, and which way it counts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from flexros.errors import InputError
from flexros.record.proposal.columns import name_words
from flexros.robot.exchange.joint_names import tagged, turned_round

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


def joints_of_file(robot: Robot) -> dict[str, str]:
    """Return the joint of the URDF or MJCF that each motor of a robot is; its own name where it is made from none.

    Args:
        robot: The robot.
    """
    return {motor: tagged(robot, motor) or motor for motor in robot.joint_names}


def match_joints(robot: Robot | None, joints: Sequence[str], bag: str) -> tuple[JointMatch, ...]:
    """Match the motors of a robot to the joints of a bag: by name, by the end of a prefixed name, else by order.

    Names whose words are the same are the same name, as `Wrist_Pitch` and `wrist_pitch`, unless two motors differ by
    them: tables write the names of joints in many ways.

    Args:
        robot: The model; one made from a URDF or an MJCF has the names of its joints as tags. None: each joint is a
            motor.
        joints: Joints of the bag.
        bag: The bag, for error messages.

    Raises:
        InputError: It is not clear which joint is a motor.
    """
    if robot is None:
        return tuple(JointMatch(f"motor_{k}", joint, 1, "order") for k, joint in enumerate(joints, start=1))
    wanted = joints_of_file(robot)
    signs: dict[str, Literal[1, -1]] = {motor: -1 if turned_round(robot, motor) else 1 for motor in robot.joint_names}
    matches = []
    for motor, name in wanted.items():
        found = _named(name, joints) or _alike(name, joints, list(wanted.values()))
        if found is not None:
            matches.append(JointMatch(motor, found[0], signs[motor], found[1]))
    if len(matches) == robot.n_motors:
        return tuple(matches)
    if not matches and len(joints) == robot.n_motors:
        return tuple(JointMatch(motor, joint, signs[motor], "order") for motor, joint in zip(robot.joint_names, joints))
    missing = ", ".join(name for motor, name in wanted.items() if motor not in {match.motor for match in matches})
    raise InputError(
        f"{bag} has the joints {', '.join(joints)}, and none of them is {missing} of robot {robot.name}; give the "
        "model of the robot in the bag, or write a mapping file"
    )


def _named(name: str, joints: Sequence[str]) -> tuple[str, Found] | None:
    """Return the joint of a name, or the only one that ends with it behind a prefix."""
    if name in joints:
        return name, "name"
    ends = [joint for joint in joints if joint.endswith(name) and joint[-len(name) - 1 : -len(name)] in ("_", "/")]
    return (ends[0], "end of the name") if len(ends) == 1 else None


def _alike(name: str, joints: Sequence[str], names: Sequence[str]) -> tuple[str, Found] | None:
    """Return the only joint with the words of a name, or that ends with them; None where two names have these words."""
    words = name_words(name)
    if not words or sum(name_words(other) == words for other in names) > 1:
        return None
    same = [joint for joint in joints if name_words(joint) == words]
    ends = [joint for joint in joints if name_words(joint)[-len(words) :] == words]
    if len(same or ends) != 1:
        return None
    return (same[0], "name") if same else (ends[0], "end of the name")
