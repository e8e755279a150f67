"""Constant torque at a motor."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.motor_law import AbstractMotorTorque, MotorState
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot.symbolic.kinematics import Value


class TorqueBias(AbstractMotorTorque):
    """A constant torque: the offset of a current sensor, a balancing spring, a wrong static load."""

    name: ClassVar[str] = "torque_bias"
    stage: ClassVar[Stage] = "actuator"
    size: ClassVar[str] = "level"
    turned: ClassVar[tuple[str, ...]] = ("level",)
    signatures: ClassVar[tuple[str, ...]] = ("effective_torque", "torque_over_speed", "torque_over_position")
    plain: ClassVar[bool] = True
    fingerprint: ClassVar[str] = (
        "a constant disturbance torque, independent of direction and position, also at standstill"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"level": Range("torque", 1e-3, 1.0, starts=2, signed=True)}
    )

    level: float = Field(0.0, description="additional torque at the motor [Nm or N]")

    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Return the constant torque."""
        del motor
        return ca.SX(values["level"])
