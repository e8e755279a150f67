"""Effects put onto a robot: what of them is another robot, and what remains as laws at its places."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.config.settings import validate
from flexros.effects.kinds.base import PlacedEffect
from flexros.effects.kinds.law import AbstractLaw
from flexros.effects.kinds.model_change import AbstractModelChange

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from flexros.robot import Robot


@dataclass(frozen=True)
class PlacedLaw:
    """A law at a place.

    Attributes:
        name: Effect and place, e.g. "coulomb_friction@motor_1"; the second one alike ends in "#2".
        effect: The effect.
        location: The place: a motor, a spring, a body, "tool" or "base".
    """

    name: str
    effect: AbstractLaw
    location: str

    @property
    def motor(self) -> int:
        """Number of the motor at which the law sits (0-based); a law elsewhere has none."""
        assert self.location.startswith("motor_"), self.name
        return int(self.location.removeprefix("motor_")) - 1

    @property
    def parameters(self) -> dict[str, float]:
        """Numbers of the law by full name, e.g. "coulomb_friction@motor_1.level"."""
        return {f"{self.name}.{key}": value for key, value in self.effect.numbers.items()}

    def check_values(self, values: Mapping[str, float], source: str) -> None:
        """Refuse numbers that the effect does not allow.

        Args:
            values: New numbers by full name; names of other laws are passed over.
            source: Who asks for them; opens the error text.

        Raises:
            InputError: Names the parameter, its value and what is allowed.
        """
        own = {name.rpartition(".")[2]: value for name, value in values.items() if name in self.parameters}
        validate(type(self.effect), {**self.effect.model_dump(), **own}, f"{source}: {self.name}")


@dataclass(frozen=True, eq=False)
class RobotWithEffects:
    """A robot with effects.

    Attributes:
        robot: The robot with all that changes its model.
        laws: Laws at its places, in the order in which they were given.
    """

    robot: Robot
    laws: tuple[PlacedLaw, ...]

    def with_effects(self, placed: Iterable[PlacedEffect]) -> RobotWithEffects:
        """Put more effects on top; laws of one kind at one place get names of their own.

        Args:
            placed: Effects with their places.

        Raises:
            InputError: The robot has no such place.
        """
        known = [PlacedEffect(law.effect, law.location) for law in self.laws]
        return place_effects(self.robot, [*known, *placed])


def place_effects(robot: Robot, placed: Iterable[PlacedEffect], *, as_laws: bool = False) -> RobotWithEffects:
    """Put effects onto a robot; those that change its model act on what those before them left.

    Args:
        robot: The robot without the effects.
        placed: Effects with their places.
        as_laws: Whether effects that can be both are laws, whose numbers can be free, and not another robot.

    Returns:
        Changed robot and laws.

    Raises:
        InputError: The robot has no such place.
    """
    laws: list[PlacedLaw] = []
    alike: Counter[str] = Counter()
    before = robot
    for given in placed:
        given.check_location(robot)
        one = given.on(before)
        lawful = as_laws and isinstance(one.effect, AbstractLaw) and bool(one.effect.numbers)
        if isinstance(one.effect, AbstractModelChange) and one.effect.changes_model(one.location) and not lawful:
            robot = one.effect.changed(robot, one.location)
            continue
        assert isinstance(one.effect, AbstractLaw)
        name = f"{one.effect.name}@{one.location}"
        alike[name] += 1
        name = name if alike[name] == 1 else f"{name}#{alike[name]}"
        laws.append(PlacedLaw(name, one.effect, one.location))
    return RobotWithEffects(robot, tuple(laws))
