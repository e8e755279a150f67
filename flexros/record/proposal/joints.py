"""Which joint of a bag is which motor of the model, and which way it counts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from flexros.errors import InputError
from flexros.record.proposal.columns import name_words, own_words
from flexros.robot.exchange.joint_names import tagged, turned_round

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.robot import Robot

Found = Literal["name", "end of the name", "own words", "order"]


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
    them: tables write the names of joints in many ways. Joints that are left are matched by the words that are their
    own, as `shoulder_joint` and `shoulder`, or `j1` and `1`.

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
    names = list(wanted.values())
    by_name = {motor: _named(name, joints) or _alike(name, joints, names) for motor, name in wanted.items()}
    found = {motor: match for motor, match in by_name.items() if match is not None}
    taken = {joint for joint, _ in found.values()}
    rest = {motor: name for motor, name in wanted.items() if motor not in found}
    found |= _with_their_words(rest, [joint for joint in joints if joint not in taken])
    if not found and len(joints) == robot.n_motors:
        found = {motor: (joint, "order") for motor, joint in zip(robot.joint_names, joints, strict=True)}
    if len(found) == robot.n_motors:
        return tuple(JointMatch(motor, found[motor][0], signs[motor], found[motor][1]) for motor in wanted)
    missing = ", ".join(name for motor, name in wanted.items() if motor not in found)
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


def _with_their_words(wanted: Mapping[str, str], joints: Sequence[str]) -> dict[str, tuple[str, Found]]:
    """Return the joints with the own words of names, where no two have the same; numbers match all together or not.

    Joints are numbered from 0 or from 1, so that the same number is the same joint only where all numbers are there and
    both count from the same one.

    Args:
        wanted: The name that each motor has, by motor.
        joints: Joints that may be theirs.
    """
    names, own = [own_words(name) for name in wanted.values()], [own_words(joint) for joint in joints]
    found: dict[str, tuple[str, Found]] = {}
    for motor, words in zip(wanted, names, strict=True):
        if words and names.count(words) == own.count(words) == 1:
            found[motor] = joints[own.index(words)], "own words"
    numbered = {motor for motor, words in zip(wanted, names, strict=True) if all(word.isdigit() for word in words)}
    if numbered <= found.keys() and (["0"] in names) == (["0"] in own):
        return found
    return {motor: joint for motor, joint in found.items() if motor not in numbered}
