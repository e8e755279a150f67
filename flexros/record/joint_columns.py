"""Columns of a topic in the order of the motors."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

_MOTOR = re.compile(r"motor_\d+")
_NUMBERED = re.compile(r".*?(\d+)\D*")


def motor_columns(
    names: Sequence[str],
    motors: Sequence[str],
    location: str,
    warnings: list[str],
    *,
    owner: str,
    states: Sequence[str] = (),
) -> list[int]:
    """Match the joints of a topic to motors.

    Names of the contract (motor_1, ...) are matched by name. Other names are matched to those of joint_states where
    the topic has them all. Else, with as many joints as motors and no name of the contract, joints are taken by the
    numbers in their names, where these are 1 ... M or 0 ... M - 1, or in their order; both with a warning.

    Args:
        names: Joint names of the topic.
        motors: Names of the motors, length M.
        location: Log and topic, for messages.
        warnings: Receives the assumption made.
        owner: What has these motors, for messages, e.g. "robot e12".
        states: Joint names of joint_states in the order of the motors; empty where they are not known.

    Returns:
        Column of each motor, length M. Further joints, such as those of a gripper, are ignored.

    Raises:
        InputError: Too few joints, too many motors, or only some names of the contract.
    """
    of_contract = [name for name in names if _MOTOR.fullmatch(name)]
    if any(name not in motors for name in of_contract):
        raise InputError(
            f"{location} has the motors {', '.join(of_contract)}, but {owner} has {len(motors)} "
            f"({', '.join(motors)}); give the robot of the log"
        )
    for wanted in (motors, states):
        if wanted and all(name in names for name in wanted):
            return [names.index(name) for name in wanted]
    if len(names) != len(motors) or any(name in motors for name in names):
        missing = [name for name in motors if name not in names]
        raise InputError(
            f"{location} has {len(names)} joints ({', '.join(names)}), but {owner} has {len(motors)} motors "
            f"({', '.join(motors)}), so {', '.join(missing)} is missing; give the robot of the log, or map its joints"
        )
    order = _by_number(names) or list(range(len(names)))
    warnings.append(
        f"{location}: {', '.join(names[i] for i in order)} are taken for {', '.join(motors)}; map the joints if that "
        "is wrong"
    )
    return order


def _by_number(names: Sequence[str]) -> list[int] | None:
    """Order joints by the numbers in their names; None where these are not consecutive from 0 or 1."""
    matches = [_NUMBERED.fullmatch(name) for name in names]
    numbers = [int(match.group(1)) for match in matches if match]
    if sorted(numbers) not in (list(range(len(names))), list(range(1, len(names) + 1))):
        return None
    return sorted(range(len(names)), key=lambda i: numbers[i])
