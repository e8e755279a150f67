"""Ranges of an effect's parameters: bounds and initial values of a fit."""

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
"""Scale of the bounds of a range: the largest torque, speed, motor angle or deflection of the gear in the log, for the
joint in question, a quotient of two of them, or 1 with the unit 1, s, Hz, periods per turn, rad."""

HIGHEST_ORDER = 10_000.0
"""Highest order of a rotor that is searched [periods per turn]: 50 per rotor turn, seen through a gear of 200
(chosen)."""

Entry = Literal["torque", "proportional torque", "gear", "encoder"]
"""Entry of a harmonic of the rotor angle: a torque at the motor, a torque relative to that of the motor, a deflection
of the gear, or an error of the encoder."""


@dataclass(frozen=True)
class HarmonicEntry:
    """Entry of an effect that is periodic in the rotor angle.

    Attributes:
        entry: The entry.
        fixed: Parameters that select this entry, with their values.
        largest: Largest amplitude [unit of the effect's amplitude].
    """

    entry: Entry
    fixed: tuple[tuple[str, bool], ...] = ()
    largest: float = float("inf")


@dataclass(frozen=True)
class Range:
    """Range of a parameter.

    Attributes:
        scale: Scale of the bounds.
        low: Smallest magnitude, as a multiple of the scale; above zero where the spacing is logarithmic.
        high: Largest magnitude, as a multiple of the scale.
        starts: Number of initial values between the bounds: logarithmic, of both signs where `signed` is set. Or the
            initial values themselves, as multiples of the scale.
        signed: Whether the parameter may also be negative; the bounds then apply to its magnitude.
        source: Origin of the range.
        negative: Largest magnitude of negative values of a signed parameter; None: that of positive ones.
        positive: Largest magnitude of positive values of a signed parameter; None: `high`.
        widest: Magnitude up to which a search that ends at `high` goes on, as a multiple of the scale; None: nowhere.
        vanishes: Bound near which the effect of the parameter vanishes; "never" for one that only shapes an effect,
            such as a speed. Signed ones vanish at zero. Parameters with a default other than zero shape an effect.
    """

    scale: Scale
    low: float
    high: float
    starts: int | tuple[float, ...] = 5
    signed: bool = False
    source: str = "chosen"
    negative: float | None = None
    positive: float | None = None
    widest: float | None = None
    vanishes: Literal["low", "high", "never"] = "low"
