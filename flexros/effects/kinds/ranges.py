"""Where the true value of an effect's parameter may lie: bounds and starts of its search."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Scale = Literal[
    "torque",
    "speed",
    "angle",
    "deflection",
    "torque/speed",
    "torque/angle",
    "relative",
    "time",
    "frequency",
    "order",
    "phase",
]
"""What the bounds of a range multiply: the largest torque, speed, motor angle or deflection of a gear in the log (of
the joint in question), a quotient of two of them, or 1 with the unit 1, s, Hz, periods per turn, rad."""

HIGHEST_ORDER = 10_000.0
"""Highest order of a rotor that is looked for [periods per turn]: 50 per turn of a rotor whose angle counts behind a
gear of 200 (chosen)."""

Entry = Literal["torque", "proportional torque", "gear", "encoder"]
"""Where a harmonic of the rotor angle enters: as a torque at the motor, as a torque relative to that of the motor, as a
deflection of the gear, or as an error of the encoder."""


@dataclass(frozen=True)
class HarmonicEntry:
    """How an effect that repeats with the rotor angle enters.

    Attributes:
        entry: Where it enters.
        fixed: Parameters that make it enter there, with their values.
        largest: Largest amplitude [unit of the effect's amplitude].
    """

    entry: Entry
    fixed: tuple[tuple[str, bool], ...] = ()
    largest: float = float("inf")


@dataclass(frozen=True)
class Range:
    """Range of a parameter.

    Attributes:
        scale: What the bounds multiply.
        low: Smallest size, as a multiple of the scale; above zero where the spacing is logarithmic.
        high: Largest size, as a multiple of the scale.
        starts: Number of starts between them: logarithmic, or where `signed` is set of both signs. Or the starts
            themselves, as multiples of the scale.
        signed: Whether the parameter may also be negative (the bounds hold of its magnitude).
        source: Where the range comes from.
        negative: Largest size of negative values of a signed parameter; None: as large as the positive ones.
    """

    scale: Scale
    low: float
    high: float
    starts: int | tuple[float, ...] = 5
    signed: bool = False
    source: str = "chosen"
    negative: float | None = None
