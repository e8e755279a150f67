"""Which column of a topic belongs to which motor."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.robot import Robot

_MOTOR = re.compile(r"motor_\d+")
_NUMBERED = re.compile(r".*?(\d+)\D*")


def motor_columns(names: tuple[str, ...], robot: Robot, place: str, warnings: list[str]) -> list[int]:
    """Match joint names to the motors of a robot.

    Names of the contract (motor_1, ...) are matched by name. Where none of them is there and there are as many joints
    as motors, joints are taken by the numbers in their names, where these are 1 ... M or 0 ... M - 1, else in their
    order, with a warning.

    Args:
        names: Joint names of the topic.
        robot: The robot.
        place: Log and topic, for the texts.
        warnings: Receives what was assumed.

    Returns:
        Column of each motor, length M; further joints, as of a gripper, are passed over.

    Raises:
        InputError: There are too few joints or too many motors, or names of which only some are those of the robot.
    """
    wanted = robot.joint_names
    beyond = [name for name in names if _MOTOR.fullmatch(name) and name not in wanted]
    if beyond:
        raise InputError(
            f"{place} has the motors {', '.join(name for name in names if _MOTOR.fullmatch(name))}, but robot "
            f"{robot.name} has {len(wanted)} ({', '.join(wanted)}); give the robot of the log"
        )
    if all(name in names for name in wanted):
        return [names.index(name) for name in wanted]
    if len(names) != len(wanted) or any(name in wanted for name in names):
        lacking = [name for name in wanted if name not in names]
        raise InputError(
            f"{place} has {len(names)} joints ({', '.join(names)}), but robot {robot.name} has {len(wanted)} motors "
            f"({', '.join(wanted)}), so {', '.join(lacking)} is missing; give the robot of the log, or map its joints"
        )
    found = [_NUMBERED.fullmatch(name) for name in names]
    order = list(range(len(names)))
    if all(found):
        numbers = [int(match.group(1)) for match in found if match]
        if sorted(numbers) in (list(range(len(names))), list(range(1, len(names) + 1))):
            order = sorted(order, key=lambda i: numbers[i])
    warnings.append(
        f"{place}: {', '.join(names[i] for i in order)} are taken for {', '.join(wanted)}; map the joints if that is "
        "wrong"
    )
    return order
