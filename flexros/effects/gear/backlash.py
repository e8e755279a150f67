"""Backlash of a gear."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.gear_law import AbstractGearLaw
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.gear_law import GearState, GearTorques
    from flexros.robot.symbolic.kinematics import Value


ROUNDING = 1e-9
"""Share of the deflection within which a flank counts as in contact [1] (chosen, far above round-off)."""


class Backlash(AbstractGearLaw):
    """Backlash between motor and arm, in series with the spring and damper of the gear.

    With total gap b, deflection d and twist s of the shaft (spring law f, damper c) the gear transmits

        f(s) + c s'    on a flank, where s = d - b/2 or s = d + b/2 (so that s' = d'),
        0              in the gap, where the remaining twist decays by f(s) + c s' = 0.

    A flank only pushes: contact ends when f(s) + c d' would pull. A dead zone with a parallel damper does not model
    this. The twist is an own state, updated after each step. As the gap goes to zero the gear becomes the nominal one.

    Reference: Nordin, Galic', Gutman 1997, New models for backlash and gear play, Int. J. Adaptive Control and
    Signal Processing 11.
    """

    name: ClassVar[str] = "backlash"
    stage: ClassVar[Stage] = "gear"
    size: ClassVar[str] = "gap"
    rank: ClassVar[int] = 2
    stepwise_states: ClassVar[int] = 1
    holds_deflection: ClassVar[bool] = True
    jumps: ClassVar[bool] = True
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"gap": Range("deflection", 1e-5, 10.0, 7, source="facts on vendors' play, 0.1 to 3 arcmin; bounds chosen")}
    )
    signatures: ClassVar[tuple[str, ...]] = ("torsion_over_torque", "detection_lines")
    fingerprint: ClassVar[str] = (
        "the motor moves alone when the transmitted torque changes its sign, then impacts and rings; the resonance "
        "frequency falls at small amplitudes, and a load that keeps one flank in contact removes the effect"
    )

    gap: float = Field(
        0.0, ge=0.0, description="total gap between the flanks, in the coordinate of the gear [rad or m]"
    )

    def added(self, gear: GearState, values: Mapping[str, Value]) -> GearTorques:
        """Replace the nominal torque by that through the gap."""
        return gear.transmits(transmitted(gear, ca.SX(values["gap"]) / 2) - gear.torque)

    def onward(self, gear: GearState, values: Mapping[str, Value]) -> GearState:
        """Pass the twist of the shaft as the deflection."""
        half = ca.SX(values["gap"]) / 2
        above, below = gear.deflection - half, gear.deflection + half
        torque = transmitted(gear, half)
        twist = ca.if_else(torque > 0, above, ca.if_else(torque < 0, below, ca.fmin(ca.fmax(gear.own, above), below)))
        return replace(gear, deflection=twist, rate=ca.if_else(torque == 0, 0, gear.rate), torque=torque)

    def after_step(self, gear: GearState, values: Mapping[str, Value], step: ca.SX) -> ca.SX:
        """Let the twist decay through the step, limited by the flanks."""
        half, damping = ca.SX(values["gap"]) / 2, ca.SX(gear.damping)
        push, pull = _flank_torques(gear, half)
        room = _rounding(gear, half)
        above, below = gear.deflection - half, gear.deflection + half
        touched = ca.logic_or(
            ca.logic_and(push > 0, gear.own <= above + room), ca.logic_and(pull < 0, gear.own >= below - room)
        )
        small = ca.if_else(gear.own == 0, 1e-12, gear.own)
        stiffness = gear.spring(small) / small
        passed = stiffness * step / ca.fmax(damping, stiffness * step / 50 + 1e-300)
        return ca.fmin(ca.fmax(ca.if_else(touched, gear.own, gear.own * ca.exp(-passed)), above), below)

    def rest(self, gear: GearState, values: Mapping[str, Value]) -> ca.SX:
        """Return the twist beyond the gap."""
        return beyond(gear.deflection, ca.SX(values["gap"]) / 2)


def beyond(deflection: ca.SX, half: ca.SX) -> ca.SX:
    """Return the deflection beyond a dead zone of half width [rad or m]."""
    return ca.fmax(deflection - half, 0) + ca.fmin(deflection + half, 0)


def transmitted(gear: GearState, half: ca.SX) -> ca.SX:
    """Evaluate the torque from motor to arm through the gap [Nm or N].

    Args:
        gear: State of the gear; its own state is the twist of the shaft at the start of the step.
        half: Half of the total gap [rad or m].
    """
    push, pull = _flank_torques(gear, half)
    room = _rounding(gear, half)
    above = ca.logic_and(push > 0, gear.deflection - half >= ca.fmin(gear.own, 0) - room)
    below = ca.logic_and(pull < 0, gear.deflection + half <= ca.fmax(gear.own, 0) + room)
    return ca.if_else(above, push, ca.if_else(below, pull, 0))


def _flank_torques(gear: GearState, half: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the torques on the flank of positive and on that of negative torque."""
    brake = gear.damping * gear.rate
    return gear.spring(gear.deflection - half) + brake, gear.spring(gear.deflection + half) + brake


def _rounding(gear: GearState, half: ca.SX) -> ca.SX:
    return ROUNDING * (ca.fabs(gear.deflection) + half)
