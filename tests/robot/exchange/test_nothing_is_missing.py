"""Every effect and every number of a patch is in the file of another program, or in the list of what it cannot hold."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from pydantic import ValidationError

from flexros.effects import PlacedEffect, effects, place_effects
from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.patching.export import FORMATS, Format, export_model
from flexros.effects.patching.patched_robot import PatchedRobot
from flexros.errors import InputError
from flexros.robot import load_robot
from tests.effects.unfitted import UNFITTED

if TYPE_CHECKING:
    from flexros.robot import Robot
    from flexros.robot.exchange.numbers import Export

pytestmark = pytest.mark.slow

ROBOTS = ("elbow", "emps_servo", "flexible_arm")


def placed(robot: Robot, kind: str, location: str) -> PlacedEffect:
    """Return an effect with parameters in the middle of their ranges, as of a scale of 1."""
    ranges = effects()[kind]().fitted(robot, location)
    numbers = {name: float(np.sqrt(allowed.low * allowed.high)) for name, allowed in ranges.items()}
    return PlacedEffect(effects()[kind](**{**UNFITTED.get(kind, {}), **numbers}), location)


def every_place(name: str) -> list[tuple[str, str, str]]:
    robot = load_robot(name)
    kinds = effects().items()
    places = [(name, kind, location) for kind, effect in kinds for location in effect().locations(robot)]
    return [each for each in places if possible(robot, placed(robot, *each[1:]))]


def possible(robot: Robot, one: PlacedEffect) -> bool:
    """Return whether it is an effect at all, and the robot can have it: a link that bends is a uniform beam."""
    try:
        return bool(one.effect != type(one.effect)() and place_effects(robot, [one]))
    except (InputError, ValidationError):
        return False


def rows(exported: Export) -> set[tuple[str, str, str]]:
    """Return location, quantity and values of all that was written or listed, as a reader sees them."""
    written = {(each.location, each.quantity, f"{each.value:.6g}") for each in exported.written}
    return written | {(each.location, each.name, each.size) for each in exported.not_held}


def export(robot: Robot, one: tuple[PlacedEffect, ...], to: Format, base: Path | None) -> Export:
    return export_model(PatchedRobot(robot, one, "patch"), to, base)


@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize(("robot", "kind", "location"), [each for name in ROBOTS for each in every_place(name)])
def test_nothing_is_missing(robot: str, kind: str, location: str, to: Format, tmp_path: Path) -> None:
    """In a new file and in one of the user: as many numbers differ as the effect changes, at least."""
    nominal, one = load_robot(robot), placed(load_robot(robot), kind, location)
    effect = one.effect
    changed = effect.values(nominal, location) if isinstance(effect, AbstractChangedValues) else {kind: 0.0}
    own = nominal.parameters
    wanted = max(sum(own[name].value != value for name, value in changed.items() if name in own), 1)
    wanted = 4 if kind == "tool_load" else wanted  # its mass and place say all that it changes
    file = tmp_path / f"own.{'xml' if to == 'mjcf' else to}"
    file.write_text(export(nominal, (), to, None).text)
    for base in (None, file) if to != "json" else (None,):
        differ = rows(export(nominal, (one,), to, base)) - rows(export(nominal, (), to, base))
        assert sum(len(re.findall(r"\d[\d.]*", f"{name} {size}")) for _, name, size in differ) >= wanted, differ
