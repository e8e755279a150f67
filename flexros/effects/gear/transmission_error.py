"""Periodic error of a gear's ratio."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.gear_law import AbstractGearLaw, GearTorques
from flexros.effects.kinds.ranges import HIGHEST_ORDER, HarmonicEntry, Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.gear_law import GearState
    from flexros.robot.symbolic.kinematics import Value


class TransmissionError(AbstractGearLaw):
    """Deflection of the gear periodic in the rotor angle.

    With amplitude A, order n, phase p and rotor angle r the gear is deflected by

        d + A sin(n r + p),    and its rate by d' + A n r' cos(n r + p),

    as for an offset of the motor. The torque T of the gear reacts on the motor times 1 + A n cos(n r + p) dr/dq, which
    conserves power between motor, spring, damper and arm.

    Reference: Taghirad, Belanger 1998, Modeling and parameter identification of harmonic drive systems, J. Dynamic
    Systems, Measurement and Control 120; order 2 of the wave generator: catalogues of strain wave gears.
    """

    name: ClassVar[str] = "transmission_error"
    stage: ClassVar[Stage] = "gear"
    size: ClassVar[str] = "amplitude"
    turned: ClassVar[tuple[str, ...]] = ("phase",)
    harmonics: ClassVar[tuple[HarmonicEntry, ...]] = (HarmonicEntry("gear"),)
    rank: ClassVar[int] = 0
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "amplitude": Range(
                "deflection", 1e-5, 1.0, 3, source="catalogues of strain wave gears: 1.5e-4 to 5.8e-4 rad"
            ),
            "order": Range("order", 0.5, HIGHEST_ORDER, 1, source="chosen; found by a search over orders"),
            "phase": Range("phase", 0.5, 3.1416, 1, signed=True),
        }
    )
    signatures: ClassVar[tuple[str, ...]] = ("order_spectrum", "torque_over_rotor_angle")
    fingerprint: ClassVar[str] = (
        "a deflection periodic in the rotor angle, with a constant amplitude as an angle, not as a torque: hardly "
        "visible in slow motion, large where order times rotor speed equals a resonance frequency"
    )

    amplitude: float = Field(0.0, ge=0.0, description="of the deflection, in the coordinate of the gear [rad or m]")
    order: float = Field(2.0, gt=0.0, description="periods per turn of the rotor [1]")
    phase: float = Field(0.0, description="phase at motor position zero [rad]")

    def added(self, gear: GearState, values: Mapping[str, Value]) -> GearTorques:
        """Replace the nominal torque by that of the shifted deflection."""
        shifted = self.onward(gear, values)
        return GearTorques(shifted.torque - gear.torque, gear.torque * gear.lever - shifted.torque * shifted.lever)

    def onward(self, gear: GearState, values: Mapping[str, Value]) -> GearState:
        """Pass the shifted deflection."""
        phase = values["order"] * gear.angle + values["phase"]
        slope = values["amplitude"] * values["order"] * gear.turns * ca.cos(phase)
        deflection = gear.deflection + values["amplitude"] * ca.sin(phase)
        rate = gear.rate + slope * gear.motor_speed
        torque = gear.spring(deflection) + gear.damping * rate
        return replace(gear, deflection=deflection, rate=rate, torque=torque, lever=gear.lever + slope)
