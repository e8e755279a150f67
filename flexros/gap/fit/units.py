"""Units of the numbers of effects, from their descriptions."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.gap.candidates.candidate import Candidate
    from flexros.robot import Robot

_UNIT = re.compile(r"\[([^\]]+)\]")


def unit_of_parameter(candidate: Candidate, name: str, robot: Robot) -> str:
    """Return the SI unit of a number of an effect.

    The descriptions of parameters state it in brackets, for rotary and linear motion as in "[rad or m]".

    Args:
        candidate: Effect at a place.
        name: Name of the number.
        robot: The robot, which tells whether the place turns or slides.
    """
    text = candidate.effect.model_fields[name].description or ""
    found = _UNIT.search(text)
    ways = (found.group(1) if found else "1").split(" or ")
    return ways[-1] if len(ways) > 1 and not _rotary(candidate.location, robot) else ways[0]


def _rotary(location: str, robot: Robot) -> bool:
    rotary = {motor.name: motor.rotary for motor in robot.motors} | {joint.name: joint.rotary for joint in robot.joints}
    return rotary.get(location, True)
