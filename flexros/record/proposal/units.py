"""Units of a proposal: by the names of columns, by the range of the joints and by the velocities."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from flexros.logs.foreign.mapping import Scale
from flexros.logs.foreign.quantities import QUANTITIES, UNITS
from flexros.logs.wrapped_positions import joined, wrap_period
from flexros.record.proposal.assumption import Assumption
from flexros.record.proposal.column_units import unit_in_name
from flexros.record.proposal.motion_units import (
    DEGREES,
    TURNS_PER_MINUTE,
    compare_velocity,
    in_degrees,
    unit_ratio,
    velocity_unit,
)

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from flexros.logs.foreign.signal_source import Signal
    from flexros.record.proposal.effort_unit import EffortUnit
    from flexros.record.proposal.found_signals import FoundSignals
    from flexros.record.proposal.joints import JointMatch

Sign = Literal[1, -1]

POSITIONS = ("position", "reference_position", "position_command")
"""Quantities that are positions."""
_UNITS_BY_RATIO = {DEGREES: ("deg", "rad/s"), 1 / DEGREES: ("rad", "deg/s")} | {
    minute: (unit, "rpm") for unit, minute in TURNS_PER_MINUTE.items()
}
"""Units of positions and velocities by the derivative of the former over the latter, where they are not alike."""
_SLIDING = {"rad": "m", "deg": "m", "rad/s": "m/s", "deg/s": "m/s", "rpm": "m/s", "Nm": "N", "mNm": "N", "kNm": "kN"}
"""Units of prismatic joints."""


def unit_words(unit: str, rotary: Mapping[str, bool]) -> str:
    """Write the unit of a quantity, with that of joints that slide, e.g. "rad, m at motor_1, motor_2".

    Args:
        unit: Unit at joints that turn.
        rotary: Whether each motor turns, by name.
    """
    sliding = [motor for motor, turns in rotary.items() if not turns]
    if not sliding:
        return unit
    of_slides = _SLIDING.get(unit, unit)
    return of_slides if len(sliding) == len(rotary) else f"{unit}, {of_slides} at {', '.join(sliding)}"


@dataclass(frozen=True)
class JointSignals:
    """The signals of the joints that are motors.

    Attributes:
        found: Names of the signals by quantity and joint.
        signals: The signals by name.
        matches: The joints.
        rotary: Whether each motor turns, by name.
    """

    found: FoundSignals
    signals: Mapping[str, Signal]
    matches: Sequence[JointMatch]
    rotary: Mapping[str, bool]

    def of(self, quantity: str, match: JointMatch) -> Signal:
        """Return the signal of a joint."""
        return self.signals[self.found.signals[quantity][match.joint]]

    def period(self, quantity: str, match: JointMatch) -> float | None:
        """Return the range after which positions of a joint that turns on begin again; None where they do not."""
        turns = quantity in POSITIONS and self.rotary[match.motor]
        return wrap_period(self.of(quantity, match).values) if turns else None

    def named_unit(self, quantity: str) -> str | None:
        """Return the unit that the names of all columns of a quantity state; None where they state none."""
        if not self.found.of_table:
            return None
        columns = [self.found.signals[quantity][match.joint] for match in self.matches]
        units = {unit_in_name(column, QUANTITIES[quantity].kind) for column in columns}
        unit = units.pop()
        fits = not units and unit is not None and set(self.rotary.values()) == {UNITS[unit].rotary}
        return unit if fits else None


@dataclass
class Units:
    """Units, signs and scales of the columns, as they are found.

    Attributes:
        units: Units by quantity, of joints that turn; torques are in Nm by default.
        signs: -1 where a quantity of a motor is opposite, by both.
        scales: Torque per unit of a current, by quantity and motor [Nm/A or N/A].
    """

    units: dict[str, str] = field(default_factory=dict)
    signs: dict[tuple[str, str], Sign] = field(default_factory=dict)
    scales: dict[tuple[str, str], float] = field(default_factory=dict)

    def take_effort(self, quantity: str, effort: EffortUnit, motors: Sequence[str]) -> None:
        """Take unit, signs and scales of an effort.

        Args:
            quantity: Its quantity.
            effort: What the comparison with the model shows.
            motors: Names of the motors.
        """
        self.units[quantity] = effort.unit
        self.signs |= {(quantity, motor): _sign(sign) for motor, sign in zip(motors, effort.signs, strict=True)}
        if effort.unit == "A":
            self.scales |= {(quantity, motor): size for motor, size in zip(motors, effort.scale, strict=True)}

    def unit(self, quantity: str, *, rotary: bool) -> str:
        """Return the unit of a quantity at a joint that turns, or at one that slides."""
        unit = self.units.get(quantity, "Nm")
        return unit if rotary else _SLIDING.get(unit, unit)

    def scale(self, quantity: str, motor: str, *, rotary: bool) -> Scale | None:
        """Return the torque per unit of a current; None for other quantities."""
        size = self.scales.get((quantity, motor))
        return None if size is None else Scale(value=size, unit="Nm/A" if rotary else "N/A")


@dataclass(frozen=True)
class MotionUnits:
    """Units of positions and velocities.

    Attributes:
        units: Units by quantity.
        signs: Signs of the velocities by quantity and motor.
        assumptions: What was assumed of them.
        against_degrees: What speaks against degrees, in words; empty for nothing.
    """

    units: Mapping[str, str]
    signs: Mapping[tuple[str, str], Sign]
    assumptions: tuple[Assumption, ...]
    against_degrees: str = ""


def units_of_motion(joints: JointSignals, quantities: Collection[str], *, modelled: bool) -> MotionUnits:
    """Find the units of positions and velocities.

    Names of columns decide, then the ratio of velocities and positions, then the range of the positions.

    Args:
        joints: The signals.
        quantities: Quantities that are used.
        modelled: Whether there is a model, which shows wrong units.
    """
    with_velocity = "velocity" in quantities
    compared, signs = _compared_velocities(joints) if with_velocity else ([], {})
    ratio = unit_ratio(compared)

    def named(quantity: str) -> str | None:
        return joints.named_unit(quantity) if quantity in quantities else None

    turning = [joints.of("position", match).values for match in joints.matches if joints.rotary[match.motor]]
    degrees = bool(turning) and in_degrees(turning)
    by_range = "deg" if degrees else "rad"
    unit, of_velocity = _UNITS_BY_RATIO.get(ratio, (by_range, f"{by_range}/s"))
    of_name = named("position")
    if of_name is not None:
        unit, of_velocity = of_name, velocity_unit(of_name, ratio)
    of_velocity = named("velocity") or of_velocity
    units = {quantity: named(quantity) or unit for quantity in POSITIONS}
    units |= {"velocity": of_velocity, "reference_velocity": named("reference_velocity") or velocity_unit(unit)}

    span = max((float(np.abs(values).max()) for values in turning), default=0.0)
    ground, against = f"the largest is {span:.3g}, {'more than' if degrees else 'within'} two turns in rad", ""
    if of_name is not None:
        ground = "names of columns say so"
    elif unit != by_range:
        ground += f", but {unit} by the velocities"
    elif degrees and of_velocity != "rpm":
        against = "; a joint that turns round and round would do so in rad"
    if not turning:
        ground = "all motors of the model slide"
    taken = f"in {unit_words(unit, joints.rotary)}"
    for match in joints.matches:
        period = joints.period("position", match)
        taken += "" if period is None else f", beginning again after {period:.4g} at {match.motor}"
    checked = degrees or modelled or of_name is not None
    assumptions = [Assumption("position", taken, f"{ground}{against}", checked)]
    if with_velocity:
        taken = unit_words(of_velocity, joints.rotary)
        assumptions.append(_about_velocity(taken, compared, signs, named=named("velocity") is not None))
    return MotionUnits(units, signs, tuple(assumptions), against)


def _about_velocity(
    unit: str, compared: Sequence[float], signs: Mapping[tuple[str, str], Sign], *, named: bool
) -> Assumption:
    """State what velocities are taken for.

    Args:
        unit: Their unit, in words.
        compared: Derivatives of the positions over them [1].
        signs: Their signs by quantity and motor.
        named: Whether names of columns state the unit.
    """
    opposite = [motor for (_, motor), sign in signs.items() if sign < 0]
    ground = "derivative of the positions over the velocities: "
    ground += f"{float(np.nanmedian(compared)):.3g}" if np.any(np.isfinite(compared)) else "not alike"
    if named:
        ground = f"names of columns say so; {ground}"
    taken = f"in {unit}" + (f", opposite at {', '.join(opposite)}" if opposite else "")
    return Assumption("velocity", taken, ground, bool(np.isfinite(unit_ratio(compared))))


def _compared_velocities(joints: JointSignals) -> tuple[list[float], dict[tuple[str, str], Sign]]:
    """Return derivatives of the positions over the velocities, and the signs of these by quantity and motor."""
    compared: list[float] = []
    signs: dict[tuple[str, str], Sign] = {}
    for match in joints.matches:
        position, velocity = joints.of("position", match), joints.of("velocity", match)
        assert position.time is not None
        period = joints.period("position", match)
        values = position.values if period is None else joined(position.values, period)
        if len(velocity.values) == len(position.values):
            result = compare_velocity(position.time, values, velocity.values)
            compared.append(result.factor)
            signs["velocity", match.motor] = _sign(result.sign)
    return compared, signs


def _sign(sign: float) -> Sign:
    return -1 if sign < 0 else 1
