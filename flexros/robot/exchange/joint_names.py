"""Which joint of a file of another program a motor or elastic direction of a robot is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.robot import Robot


def motor_joints(robot: Robot, joints: Sequence[str], given: Mapping[str, str], source: str) -> dict[str, str]:
    """Return the joint of each motor: as given, by the tag of the robot file, by equal name, else in order.

    Args:
        robot: The robot; an imported one has the tags `motor_1.joint`, ...
        joints: Names of the movable joints of the file, in order of the chain.
        given: Joint by motor, as the user states it.
        source: The file, for error messages.

    Raises:
        InputError: A name is unknown, or it is not clear which joint is meant.
    """
    for motor in given:
        if motor not in robot.joint_names:
            raise _of_argument(unknown_name("motor", motor, robot.joint_names))
    found = {}
    for motor in robot.joint_names:
        name = given.get(motor, "")
        if name and name not in joints:
            raise _of_argument(unknown_name(f"joint of {motor}", name, joints, source))
        name = next((each for each in (name, tagged(robot, motor), motor) if each in joints), "")
        if name:
            found[motor] = name
    if not found and len(joints) == robot.n_motors:
        found = dict(zip(robot.joint_names, joints))
    missing = [motor for motor in robot.joint_names if motor not in found]
    if missing:
        raise _of_argument(
            InputError(
                f"{source} has the joints {', '.join(joints) or '(none)'}, and it is not clear which are "
                f"{', '.join(missing)} of robot {robot.name}; give each as MOTOR=JOINT"
            )
        )
    return found


def tagged(robot: Robot, coordinate: str) -> str:
    """Return the joint that the robot file names for a motor or arm coordinate, empty for none."""
    return robot.spec.tags.get(f"{coordinate}.joint", "")


def turned_round(robot: Robot, coordinate: str) -> bool:
    """Return whether a motor or arm coordinate counts the other way round than the joint of the imported file."""
    return robot.spec.tags.get(f"{coordinate}.joint_sign") == "-1"


def all_turned_round(robot: Robot) -> frozenset[str]:
    """Return the motors and arm coordinates that count the other way round than the joints of the imported file."""
    return frozenset(name for name in (*robot.joint_names, *robot.arm_names) if turned_round(robot, name))


def joints_line(robot: Robot) -> str:
    """Say which joint of the imported file each motor is, and which count the other way round; empty for no import."""
    named = [(motor, joint) for motor in robot.joint_names if (joint := tagged(robot, motor))]
    opposite = [joint for motor, joint in named if turned_round(robot, motor)]
    text = ", ".join(f"{motor} = {joint}" for motor, joint in named)
    signs = f"; {', '.join(opposite)} count{'s' * (len(opposite) == 1)} the other way round" if opposite else ""
    return f"Joints: {text}{signs}" if named else ""


def _of_argument(error: InputError) -> InputError:
    error.argument = "joint"
    return error
