"""What may be the cause: effects at places, and the numbers of them that are fitted."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import PlacedEffect, effects

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.effects import AbstractEffect
    from flexros.effects.kinds.ranges import Range
    from flexros.gap.candidates.scales import Scales
    from flexros.robot import Robot


@dataclass(frozen=True)
class FreeParameter:
    """A number of an effect that is fitted; positive ones by their logarithm.

    Attributes:
        name: Name within the effect.
        low: Smallest size [its unit].
        high: Largest size [its unit].
        signed: Whether it may be negative; then it is fitted as it is, in multiples of `high`.
        starts: Values from which the fit starts [its unit].
        negative: Largest size of negative values, not above `high` [its unit]; None: `high`.
    """

    name: str
    low: float
    high: float
    signed: bool
    starts: tuple[float, ...]
    negative: float | None = None

    def encode(self, value: float) -> float:
        """Turn a value into the number that the fit moves."""
        return value / self.high if self.signed else float(np.log(max(value, self.low)))

    def decode(self, number: FloatArray) -> FloatArray:
        """Turn numbers of the fit into values."""
        return number * self.high if self.signed else np.exp(number)

    @property
    def bounds(self) -> tuple[float, float]:
        """Bounds of the number that the fit moves."""
        if not self.signed:
            return float(np.log(self.low)), float(np.log(self.high))
        return -min(1.0, (self.high if self.negative is None else self.negative) / self.high), 1.0


@dataclass(frozen=True)
class Candidate:
    """An effect at a place whose numbers are unknown.

    Attributes:
        effect: Class of the effect.
        location: Its place.
        free: The numbers that are fitted.
        fixed: Other numbers of it that are not at their defaults.
        together: Whether the starts of the numbers belong together, one of each; else all combinations count.
    """

    effect: type[AbstractEffect]
    location: str
    free: tuple[FreeParameter, ...]
    fixed: tuple[tuple[str, float | bool], ...] = ()
    together: bool = False

    @property
    def name(self) -> str:
        """Effect and place, e.g. "coulomb_friction@motor_1"."""
        return f"{self.effect.name}@{self.location}"

    def starts(self) -> list[tuple[float, ...]]:
        """List the numbers from which a fit starts, as it moves them."""
        numbers = [[one.encode(value) for value in one.starts] for one in self.free]
        return list(zip(*numbers, strict=True) if self.together else product(*numbers))

    def placed(self, values: Mapping[str, float]) -> PlacedEffect:
        """Make the effect with numbers.

        Args:
            values: Values of the free parameters by name [their units].
        """
        return PlacedEffect(self.effect(**{**dict(self.fixed), **values}), self.location)

    def typical(self) -> PlacedEffect:
        """Make the effect with one of its starts, none of them neutral."""
        return self.placed({one.name: one.starts[len(one.starts) // 2] for one in self.free})


Hypothesis = tuple[Candidate, ...]
"""Effects that are there together; the empty one is "nothing"."""


def names_of(hypothesis: Hypothesis) -> frozenset[str]:
    """Name the effects at places of a hypothesis."""
    return frozenset(candidate.name for candidate in hypothesis)


def name_of(hypothesis: Hypothesis) -> str:
    """Name a hypothesis by its effects and places."""
    return " + ".join(candidate.name for candidate in hypothesis) or "nothing"


def free_parameter(name: str, allowed: Range, scale: float) -> FreeParameter:
    """Put the range of a parameter into the units of a log.

    Args:
        name: Name within the effect.
        allowed: Its range.
        scale: What the bounds of the range multiply.
    """
    low, high = allowed.low * scale, allowed.high * scale
    negative = high if allowed.negative is None else allowed.negative * scale
    if isinstance(allowed.starts, tuple):
        starts = tuple(start * scale for start in allowed.starts)
    elif allowed.signed:
        half = np.geomspace(low, high, max(1, (allowed.starts + 1) // 2) + 1)[:-1]
        starts = tuple(
            float(sign * min(size, limit)) for size in half for sign, limit in ((1.0, high), (-1.0, negative))
        )
    else:
        # the middle of equal parts of the logarithmic range
        parts = (np.arange(allowed.starts) + 0.5) / allowed.starts
        starts = tuple(float(x) for x in low * (high / low) ** parts)
    return FreeParameter(name, low, high, allowed.signed, starts, negative)


def list_candidates(robot: Robot, scales: Scales) -> tuple[Candidate, ...]:
    """List every effect at every place that a fit can look for.

    Args:
        robot: The nominal robot.
        scales: Largest torques, speeds and deflections of the log.

    Returns:
        Candidates; effects without ranges are left out, and those that repeat with the rotor, whose orders are sought
        apart.
    """
    found: list[Candidate] = []
    for effect in effects().values():
        if not effect.ranges or "order" in effect.ranges:
            continue
        for location in places(effect, robot):
            free = tuple(
                free_parameter(name, allowed, scales.of(allowed.scale, location))
                for name, allowed in effect().fitted(robot, location).items()
            )
            found.append(Candidate(effect, location, free))
    return tuple(found)


def places(effect: type[AbstractEffect], robot: Robot) -> tuple[str, ...]:
    """List the places of an effect that differ: on a robot with one motor, "all" is that motor.

    Args:
        effect: Class of the effect.
        robot: The robot.
    """
    found = effect().locations(robot)
    if "all" in found and robot.n_motors == 1:
        found = tuple(place for place in found if place not in robot.joint_names)
    return found
