"""The truth of a case as a model of the library: the true robot with its hidden effects at their true numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from flexros.effects import PlacedEffect, RobotWithEffects, effects, place_effects
from flexros.validation.blind.draw.case_robots import case_robot
from flexros.validation.blind.plant.laws import LIBRARY_LAWS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.robot import Robot
    from flexros.validation.blind.deviation import Deviation
    from flexros.validation.blind.seal import Truth


def library_effects(truth: Truth) -> tuple[Deviation, ...]:
    """List what is hidden of the effects library: effects that it has, at places where it has them on the robot.

    A base that gives under a robot whose first direction is rigid is outside it, as no name could be right.
    """
    robot = case_robot(truth.robot)
    return tuple(
        one
        for one in truth.deviations
        if one.effect in LIBRARY_LAWS and one.location in effects()[one.effect]().locations(robot)
    )


def true_model(truth: Truth, chosen: Sequence[Deviation] | None = None, robot: Robot | None = None) -> RobotWithEffects:
    """Build a robot with hidden effects; laws are those of the library, which differ in form from the plant's.

    Args:
        truth: What is hidden.
        chosen: Some of it; all when None.
        robot: Robot that they are put on; the true one when None.

    Raises:
        InputError: A number is none that the library allows.
    """
    true = case_robot(truth.robot)
    used = library_effects(truth) if chosen is None else chosen
    return place_effects(robot or true, [_placed(one, true) for one in used])


def _placed(one: Deviation, robot: Robot) -> PlacedEffect:
    """Convert numbers of the plant to those of the library."""
    kind, numbers = effects()[one.effect], dict(one.parameters)
    if one.effect == "friction_drift":
        grown = 1 - math.exp(-numbers["duration"] / numbers["time_constant"])
        numbers |= {name: numbers[name] / grown for name in ("coulomb", "viscous")}
    if one.effect == "viscous_friction":  # the library's asymmetry is that of the whole friction
        whole = robot.parameters[f"{one.location}.viscous_friction"].value + numbers["coefficient"]
        numbers["asymmetry"] *= numbers["coefficient"] / whole
    if one.effect == "extra_mode" and one.location == "tool" and not numbers.get("point"):
        heavy = robot.spec.bodies[-1].mass.value > 0
        numbers |= {"ratio": 0.0, "inertia_ratio": numbers["ratio"]} if heavy else {}
    known = {name: value for name, value in numbers.items() if name in kind.model_fields}
    if "proportional" in known:
        return PlacedEffect(kind.model_validate({**known, "proportional": known["proportional"] > 0.5}), one.location)
    return PlacedEffect(kind.model_validate(known), one.location)
