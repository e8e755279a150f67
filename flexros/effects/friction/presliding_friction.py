"""Bristle friction, with deflection before sliding."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field, model_validator

from flexros.effects.kinds.bristle_friction import AbstractBristleFriction, Bristle
from flexros.effects.kinds.hump import GAUSSIAN, SLOWEST, hump
from flexros.effects.kinds.ranges import Range
from flexros.effects.kinds.yielding_friction import SOFTEST

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot.symbolic.kinematics import Value


SEEN = 3.0
"""Smallest detectable deflection of the bristles at break-away, in units of the encoder noise [1] (chosen)."""


class PreslidingFriction(AbstractBristleFriction):
    """LuGre friction at a motor, without its viscous term (Canudas de Wit 1995; Moberg 2007, eq. 3.15).

    With bristle deflection z, speed v, stiffness s0 and damping s1 the torque against the motion is s0 z + s1 dz/dt,
    where dz/dt = v - s0 |v| z / g(v) and g(v) = level + extra exp(-|v / velocity|^exponent). Steady sliding has torque
    g(v); below break-away the motor moves as on a spring of stiffness s0. With a `damping_velocity` w the damping fades
    with the speed, s1 exp(-(v / w)^2) (eq. 3.15c); no fit looks for w. Integration: `bristle_friction`, of order two in
    the integration step where it resolves the motion.
    """

    name: ClassVar[str] = "presliding_friction"
    stage: ClassVar[Stage] = "motor friction"
    size: ClassVar[str] = "level"
    further_sizes: ClassVar[tuple[str, ...]] = ("extra",)
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_speed", "torque_after_reversal", "detection_lines")
    fingerprint: ClassVar[str] = (
        "friction torque that builds up over a small angle after each reversal, with a loop of torque over angle, and "
        "motion as on a spring below break-away"
    )
    extends: ClassVar[Mapping[str, Mapping[str, str]]] = MappingProxyType(
        {
            "coulomb_friction": MappingProxyType({"level": "level"}),
            "stribeck_friction": MappingProxyType({"extra": "extra", "velocity": "velocity", "exponent": "exponent"}),
        }
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "level": Range("torque", 1e-6, 1.0, starts=1),
            "extra": Range("torque", 1e-7, 1.0, starts=1),
            "velocity": Range("speed", 1e-3, 1.0, starts=1, vanishes="never"),
            "exponent": Range("relative", 0.5, 4.0, starts=1, source="that of Stribeck friction"),
            "stiffness": Range("torque/angle", SOFTEST, 1e6, starts=9, vanishes="never"),
            "damping": Range("torque/speed", 1e-6, 10.0, starts=3),
        }
    )

    level: float = Field(0.0, ge=0.0, description="Coulomb level, reached at high speed [Nm or N]")
    extra: float = Field(0.0, ge=0.0, description="level at standstill beyond that of high speed [Nm or N]")
    velocity: float = Field(0.0, ge=0.0, description="Stribeck velocity of the motor [rad/s or m/s]")
    exponent: float = Field(GAUSSIAN, gt=0.0, le=8.0, description="shape of the Stribeck hump [1]; 2 is Gaussian")
    stiffness: float = Field(0.0, ge=0.0, description="bristle stiffness s0 at the motor [Nm/rad or N/m]")
    damping: float = Field(0.0, ge=0.0, description="bristle damping s1 at the motor [Nm s/rad or N s/m]")
    damping_velocity: float = Field(
        0.0, ge=0.0, description="speed over which the bristle damping fades [rad/s or m/s]; 0 for constant damping"
    )

    @model_validator(mode="after")
    def _stiff(self) -> PreslidingFriction:
        if not self.neutral and self.stiffness <= 0:
            raise ValueError("stiffness is 0, but must be positive; give stiffness=... [Nm/rad or N/m]")
        return self

    def bristle(self, speed: ca.SX, values: Mapping[str, Value]) -> Bristle:
        """Evaluate the Stribeck curve."""
        level = values["level"] + hump(speed, values["extra"], values["velocity"], values["exponent"])
        return Bristle(ca.SX(level), values["stiffness"], _faded(speed, values["damping"], values["damping_velocity"]))

    def visible(self, noise: float) -> bool:
        """Return whether the deflection of the bristles exceeds the encoder noise; otherwise it is Coulomb friction."""
        return self.level + self.extra > SEEN * noise * self.stiffness


def _faded(speed: ca.SX, damping: Value, velocity: Value) -> Value:
    """Evaluate the bristle damping at a speed, damping exp(-(v / velocity)^2), constant for a velocity of 0."""
    if not isinstance(velocity, ca.SX) and velocity == 0:
        return damping
    return damping * ca.if_else(velocity > 0, ca.exp(-((speed / ca.fmax(velocity, SLOWEST)) ** 2)), 1.0)
