"""Laws of a plant by kind."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from flexros.effects.kinds.arm_law import AbstractArmLaw
from flexros.effects.kinds.bristle_friction import AbstractBristleFriction
from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.effects.kinds.dry_friction import AbstractDryFriction
from flexros.effects.kinds.gear_law import AbstractGearLaw
from flexros.effects.kinds.motor_law import AbstractMotorTorque
from flexros.effects.kinds.sensor import AbstractSensor
from flexros.effects.kinds.tool_error import AbstractToolError

if TYPE_CHECKING:
    from flexros.effects.patching.placement import PlacedLaw


@dataclass(frozen=True, eq=False)
class LawsByKind:
    """Laws with their effects, in the order given; an effect may be of several kinds.

    Attributes:
        all: All laws.
    """

    all: tuple[PlacedLaw, ...]

    @cached_property
    def commands(self) -> list[tuple[PlacedLaw, AbstractCommandLaw]]:
        """Laws between torque command and motor, in order of `rank`."""
        return [(law, effect) for law, effect in self._commands if not effect.filters_positions]

    @cached_property
    def position_filters(self) -> list[tuple[PlacedLaw, AbstractCommandLaw]]:
        """Laws between commanded position and servo."""
        return [(law, effect) for law, effect in self._commands if effect.filters_positions]

    @cached_property
    def _commands(self) -> list[tuple[PlacedLaw, AbstractCommandLaw]]:
        laws = [(law, law.effect) for law in self.all if isinstance(law.effect, AbstractCommandLaw)]
        return sorted(laws, key=lambda pair: pair[1].rank)

    @cached_property
    def torques(self) -> list[tuple[PlacedLaw, AbstractMotorTorque]]:
        """Continuous torques at motors."""
        return [(law, law.effect) for law in self.all if isinstance(law.effect, AbstractMotorTorque)]

    @cached_property
    def frictions(self) -> list[tuple[PlacedLaw, AbstractDryFriction]]:
        """Friction with sticking."""
        return [(law, law.effect) for law in self.all if isinstance(law.effect, AbstractDryFriction)]

    @cached_property
    def bristles(self) -> list[tuple[PlacedLaw, AbstractBristleFriction]]:
        """Friction with presliding."""
        return [(law, law.effect) for law in self.all if isinstance(law.effect, AbstractBristleFriction)]

    @cached_property
    def gears(self) -> list[tuple[PlacedLaw, AbstractGearLaw]]:
        """Laws of springs, in order of `rank`."""
        laws = [(law, law.effect) for law in self.all if isinstance(law.effect, AbstractGearLaw)]
        return sorted(laws, key=lambda pair: pair[1].rank)

    @cached_property
    def arms(self) -> list[tuple[PlacedLaw, AbstractArmLaw]]:
        """Laws of the arm."""
        return [(law, law.effect) for law in self.all if isinstance(law.effect, AbstractArmLaw)]

    @cached_property
    def sensors(self) -> list[tuple[PlacedLaw, AbstractSensor]]:
        """Errors of encoders, in order of `rank`."""
        laws = [(law, law.effect) for law in self.all if isinstance(law.effect, AbstractSensor)]
        return sorted(laws, key=lambda pair: pair[1].rank)

    @cached_property
    def tool_errors(self) -> list[tuple[PlacedLaw, AbstractToolError]]:
        """Errors of the tool pose."""
        return [(law, law.effect) for law in self.all if isinstance(law.effect, AbstractToolError)]
