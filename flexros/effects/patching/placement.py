"""Effects applied to a robot: those that change its model, and those that remain laws at its locations."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flexros.config.settings import validate
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.kinds.base import PlacedEffect
from flexros.effects.kinds.law import AbstractLaw
from flexros.effects.kinds.model_change import AbstractModelChange
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from flexros.robot import Robot
    from flexros.robot.robot import Commands


@dataclass(frozen=True)
class PlacedLaw:
    """A law at a location.

    Attributes:
        name: Effect and location, e.g. "coulomb_friction@motor_1"; a second one of the same kind ends in "#2".
        effect: The law that acts.
        location: A motor, a spring, a body, "tool" or "base".
        given: The effect that selects this law, where that is another one.
    """

    name: str
    effect: AbstractLaw
    location: str
    given: AbstractLaw | None = None

    @property
    def motor(self) -> int:
        """Index of the motor of a law at a motor."""
        assert self.location.startswith("motor_"), self.name
        return int(self.location.removeprefix("motor_")) - 1

    @property
    def parameters(self) -> dict[str, float]:
        """Parameter values of the law by full name, e.g. "coulomb_friction@motor_1.level"."""
        return {f"{self.name}.{key}": value for key, value in self.effect.parameter_values.items()}

    def with_values(self, values: Mapping[str, float], source: str) -> PlacedLaw:
        """Return the law with other values of its parameters.

        Args:
            values: New values by full name; names of other laws are skipped.
            source: Origin of the values; prefix of the error message.

        Raises:
            InputError: Names the parameter, its value and the allowed values.
        """
        own = {name.rpartition(".")[2]: value for name, value in values.items() if name in self.parameters}
        effect = validate(type(self.effect), {**self.effect.model_dump(), **own}, f"{source}: {self.name}")
        return replace(self, effect=effect)


@dataclass(frozen=True, eq=False)
class RobotWithEffects:
    """A robot with effects, the model of a plant.

    Attributes:
        robot: The robot including all model changes.
        laws: Laws at its locations, in the order given.
        added_delay: Part of the robot's delay that effects added [s]. The motion is late by it to measured torques too,
            which the delay of the robot file precedes.
    """

    robot: Robot
    laws: tuple[PlacedLaw, ...]
    added_delay: float = 0.0

    def commanded_by(self, commands: Commands) -> RobotWithEffects:
        """Return the same with another input of the robot, see `Robot.commanded_by`."""
        robot = self.robot.commanded_by(commands)
        return self if robot is self.robot else replace(self, robot=robot)

    def with_effects(self, placed: Iterable[PlacedEffect]) -> RobotWithEffects:
        """Add effects; laws of one kind at one location get distinct names.

        Raises:
            InputError: The robot has no such location.
        """
        known = [PlacedEffect(law.given or law.effect, law.location) for law in self.laws]
        model = place_effects(self.robot, [*known, *placed])
        return replace(model, added_delay=self.added_delay + model.added_delay)


def place_effects(robot: Robot, placed: Iterable[PlacedEffect], *, as_laws: bool = False) -> RobotWithEffects:
    """Apply effects to a robot; model changes are applied one after the other.

    Args:
        robot: The robot without the effects.
        placed: Effects with their locations.
        as_laws: Whether effects that can be either are placed as laws, with free parameters, not as model changes.

    Raises:
        InputError: The robot has no such location, or an effect has a value that the robot does not allow there.
    """
    laws: list[PlacedLaw] = []
    counts: Counter[str] = Counter()
    nominal = robot
    for given in placed:
        given.check_location(robot)
        effect, location = (resolved := given.on(nominal)).effect, resolved.location
        effect.check_on(nominal, location)
        as_law = as_laws and isinstance(effect, AbstractLaw) and bool(effect.parameter_values)
        if isinstance(effect, AbstractModelChange) and effect.changes_model(location) and not as_law:
            robot = effect.changed(robot, location)
            continue
        assert isinstance(effect, AbstractLaw)
        name = f"{effect.name}@{location}"
        counts[name] += 1
        name = name if counts[name] == 1 else f"{name}#{counts[name]}"
        acting = effect.acting
        laws.append(PlacedLaw(name, acting, location, given=None if acting is effect else effect))
    check_levels(laws)
    return RobotWithEffects(robot, tuple(laws), robot.delay - nominal.delay)


def check_levels(laws: Sequence[PlacedLaw], source: str = "") -> None:
    """Refuse Coulomb friction that takes more away than other effects put there.

    Args:
        laws: All laws of a plant.
        source: Origin of the values; prefix of the error message.

    Raises:
        InputError: Names the law, its level and the least one.
    """
    for law in laws:
        if not isinstance(law.effect, CoulombFriction) or law.effect.level >= 0:
            continue
        others = [other.effect for other in laws if other.location == law.location and other is not law]
        most = sum(effect.level for effect in others if isinstance(effect, CoulombFriction))
        if law.effect.level < -most - 1e-9 * abs(most):
            raise InputError(
                f"{source}{': ' if source else ''}{law.name}: level is {law.effect.level:g}, but the model has a "
                f"Coulomb friction of {most:g} there; give at least {-most:g}"
            )
