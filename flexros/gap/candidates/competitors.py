"""Which effects compete, and at which locations: all, or those that the settings name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.effects import effects
from flexros.effects.kinds.curve import AbstractCurve
from flexros.effects.kinds.tool_error import AbstractToolError
from flexros.errors import InputError, argument_named, unknown_name
from flexros.gap.candidates.candidate import distinct_locations
from flexros.robot.exchange.joint_names import tagged

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.effects import AbstractEffect
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.settings import SearchSettings
    from flexros.record.record import Record
    from flexros.robot import Robot


@dataclass(frozen=True)
class Competitors:
    """The effects and locations that compete.

    Attributes:
        effects: Names of the effects.
        locations: Locations; None for all.
        without: Motors at which none competes, as their motion is prescribed.
    """

    effects: frozenset[str]
    locations: frozenset[str] | None
    without: frozenset[str] = frozenset()

    def include(self, effect: type[AbstractEffect]) -> bool:
        """Return whether an effect competes anywhere."""
        return effect.name in self.effects

    def contain(self, candidate: Candidate) -> bool:
        """Return whether an effect competes at its location."""
        if not self.include(candidate.effect) or candidate.location in self.without:
            return False
        return self.locations is None or candidate.location in self.locations


def competitors(robot: Robot, settings: SearchSettings, prescribed: Sequence[int] = ()) -> Competitors:
    """Return what competes on a robot.

    Args:
        robot: The nominal robot.
        settings: Names of effects and motors.
        prescribed: Motors whose motion is prescribed.

    Raises:
        InputError: An effect or a motor does not exist, or none of the effects can act at the motors.
    """
    known = effects()
    with argument_named("effects"):
        for name in settings.effects:
            if name not in known:
                raise unknown_name("effect", name, known, "search.effects")
    without = frozenset(robot.joint_names[motor] for motor in prescribed)
    names = settings.effects or [name for name, effect in known.items() if not effect.on_request]
    competing = Competitors(frozenset(names), locations_of(robot, settings.joints), without)
    if competing.locations is not None and not any(
        location in competing.locations - without
        for name in competing.effects
        for location in known[name]().locations(robot)
    ):
        raise InputError(
            f"none of the effects {', '.join(sorted(competing.effects))} can act at {', '.join(settings.joints)}: give "
            "other effects, or more motors",
            "joints",
        )
    return competing


def not_sought(record: Record, robot: Robot, settings: SearchSettings) -> tuple[str, ...]:
    """Say which of the effects that the settings name a log cannot show anywhere, one sentence each.

    Where it is open whether one is found, as in a simulated log that torques may begin with, none is given.

    Args:
        record: The log.
        robot: The nominal robot, commanded as in the log.
        settings: Names of effects and motors.
    """
    known, where, texts = effects(), locations_of(robot, settings.joints), list[str]()
    curves = any(issubclass(known[name], AbstractCurve) for name in settings.effects)
    for effect in (known[name] for name in settings.effects):
        if not effect.ranges or effect.harmonics or issubclass(effect, AbstractCurve):
            continue
        found = distinct_locations(effect, robot, measured=True)
        if record.command is None or curves:
            found += distinct_locations(effect, robot, for_curve=True)
        if record.tool is None and issubclass(effect, AbstractToolError):
            found = ()
        sought, acts = (
            any(where is None or location in where for location in locations)
            for locations in (found, effect().locations(robot))
        )
        if not acts or (not sought and effect.sought_where):
            at = f" at {', '.join(settings.joints)}" if where else ""
            why = f"it is sought only {effect.sought_where}" if acts else f"it cannot act on robot {robot.name}{at}"
            texts.append(f"{effect.name} was named as a candidate, but is not sought in this log: {why}")
    return tuple(texts)


def locations_of(robot: Robot, motors: Sequence[str]) -> frozenset[str] | None:
    """List the locations that belong to motors: they, the springs up to the next motor, and the bodies of these.

    Springs and bodies before the first motor belong to it. Tool, base and "all" concern every motor: they belong to
    all motors together.

    Args:
        robot: The robot.
        motors: Names of motors, or of their joints where the robot file names them; none for no restriction.

    Returns:
        The locations; None for all, where no motor or every one is given.

    Raises:
        InputError: A motor does not exist.
    """
    by_name = {tagged(robot, name) or name: name for name in robot.joint_names}
    by_name |= {name: name for name in robot.joint_names}
    with argument_named("joints"):
        for name in motors:
            if name not in by_name:
                raise unknown_name("motor", name, by_name, "search.joints")
    named = {by_name[name] for name in motors}
    if not named or named == set(robot.joint_names):
        return None
    surroundings = _surroundings(robot)
    return frozenset(location for name in named for location in surroundings[name])


def _surroundings(robot: Robot) -> dict[str, set[str]]:
    """List the locations that belong to each motor, body after body."""
    locations = {name: {name} for name in robot.joint_names}
    by_joint = {motor.joint.name: motor.name for motor in robot.motors}
    owners = [robot.joint_names[0]]
    for number in range(1, len(robot.spec.bodies) + 1):
        body = f"body_{number}"
        names = [joint.name for joint in robot.joints if joint.name.partition(".")[0] == body]
        owners = [by_joint[name] for name in names if name in by_joint] or owners
        for owner in owners:
            locations[owner] |= {body, *(name for name in names if by_joint.get(name, owner) == owner)}
    return locations
