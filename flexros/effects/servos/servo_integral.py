"""Integral part of a servo."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.ranges import Range
from flexros.effects.kinds.servo_number import AbstractServoNumber

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage


class ServoIntegral(AbstractServoNumber):
    """The gain of a position loop on the integral of its error, beyond that of the robot file.

    With nominal gain k and error g the servo adds a torque T_i with dT_i/dt = (k + g) (command - q), which rests while
    the torque is at its limit and would go beyond. It is sought in logs with position commands only; a run begins with
    the T_i of a robot at rest.
    """

    name: ClassVar[str] = "servo_integral"
    stage: ClassVar[Stage] = "actuator"
    size: ClassVar[str] = "gain"
    number: ClassVar[str] = "integral"
    signatures: ClassVar[tuple[str, ...]] = ("effective_torque", "torque_over_position")
    fingerprint: ClassVar[str] = (
        "under a constant load the motor creeps to its commanded position, it overshoots after moves, and hunts where "
        "friction holds it"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType({"gain": Range("torque/angle", 1e-3, 1e4, starts=7)})

    gain: float = Field(
        0.0, description="beyond that of the robot file; below zero where that is too large [Nm/(rad s) or N/(m s)]"
    )

    @property
    def added(self) -> float:
        """The gain."""
        return self.gain
