"""Friction that changes during operation: warming grease, running-in."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.dry_friction import AbstractDryFriction, FrictionLevels
from flexros.effects.kinds.motor_law import AbstractMotorTorque, MotorState
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot.symbolic.kinematics import Value

_SHORT = 1e-12


class FrictionDrift(AbstractMotorTorque, AbstractDryFriction):
    """Change of friction at a motor from the start of the run on (Bittencourt 2010: it follows the temperature).

    At time t, with time constant T, the torque against the motion of speed v is (coulomb sign(v) + viscous v)
    (1 - exp(-t/T)): zero at the start, the whole change at the end, so the effect includes its own mean. Both changes
    may be negative; the sum of the levels of dry friction at a motor does not fall below zero. The own state is the
    time.
    """

    name: ClassVar[str] = "friction_drift"
    stage: ClassVar[Stage] = "motor friction"
    size: ClassVar[str] = "coulomb"
    further_sizes: ClassVar[tuple[str, ...]] = ("viscous",)
    smooth_states = 1
    eases = True
    signatures: ClassVar[tuple[str, ...]] = ("friction_over_time", "torque_over_speed")
    fingerprint: ClassVar[str] = (
        "equal motions late in the log have another disturbance torque against the motion than early ones"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "coulomb": Range("torque", 1e-3, 0.5, starts=1, signed=True),
            "viscous": Range("torque/speed", 1e-3, 0.5, starts=1, signed=True),
            "time_constant": Range("time", 3.0, 1000.0, starts=3),
        }
    )

    coulomb: float = Field(0.0, description="change of the Coulomb level from start to end [Nm or N]")
    viscous: float = Field(0.0, description="change of the viscous coefficient from start to end [Nm s/rad or N s/m]")
    time_constant: float = Field(10.0, gt=0.0, description="time constant of the change [s]")

    def states_of_time(self, time: float) -> tuple[float, ...]:
        """Return the time itself."""
        return (time,)

    def rates(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Return the rate of the time, 1."""
        del motor, values
        return ca.SX(1)

    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Return the change of viscous friction."""
        return -values["viscous"] * _reached(motor, values) * motor.speed

    def levels(self, motor: MotorState, values: Mapping[str, Value]) -> FrictionLevels:
        """Return the level reached so far."""
        level = values["coulomb"] * _reached(motor, values)
        return FrictionLevels(level, level)


def _reached(motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
    """Return the share of the change reached so far."""
    return 1 - ca.exp(-motor.own[0] / ca.fmax(values["time_constant"], _SHORT))
