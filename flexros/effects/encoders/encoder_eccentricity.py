"""Periodic error of an encoder, as of a disc mounted off centre."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.ranges import HIGHEST_ORDER, HarmonicEntry, Range
from flexros.effects.kinds.sensor import AbstractSensor

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot.symbolic.kinematics import Value


class EncoderEccentricity(AbstractSensor):
    """One order of a Fourier series in the rotor angle, added to the encoder's measurement.

    With amplitude A, order n, phase p and rotor angle a the measurement is A sin(n a + p) too large. The amplitude
    refers to the motor coordinate, the order to turns of the rotor, as for `torque_ripple`. Several orders are several
    effects.
    """

    name: ClassVar[str] = "encoder_eccentricity"
    stage: ClassVar[Stage] = "sensor"
    size: ClassVar[str] = "amplitude"
    turned: ClassVar[tuple[str, ...]] = ("phase",)
    harmonics: ClassVar[tuple[HarmonicEntry, ...]] = (HarmonicEntry("encoder"),)
    rank: ClassVar[int] = 0
    signatures: ClassVar[tuple[str, ...]] = ("order_spectrum", "torque_over_rotor_angle")
    fingerprint: ClassVar[str] = (
        "an error of position, not of torque, periodic in the motor angle, with the same amplitude at all speeds"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "amplitude": Range("angle", 1e-8, 1e-2, starts=3),
            "order": Range("order", 0.5, HIGHEST_ORDER, starts=1),
            "phase": Range("phase", 0.5, 3.1416, starts=1, signed=True),
        }
    )

    amplitude: float = Field(0.0, ge=0.0, description="amplitude of the error, of the motor coordinate [rad or m]")
    order: float = Field(1.0, gt=0.0, description="periods per turn of the rotor [1]")
    phase: float = Field(0.0, description="phase at motor position zero [rad]")

    def read(self, position: ca.SX, angle: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Add the harmonic at the rotor angle."""
        return position + values["amplitude"] * ca.sin(values["order"] * angle + values["phase"])
