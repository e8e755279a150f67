"""Resolution of an encoder."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.sensor import AbstractSensor

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot.symbolic.kinematics import Value


class EncoderQuantization(AbstractSensor):
    """Measured positions rounded to the nearest multiples of a step.

    A diagnosis finds the step from the levels in the log, not by a fit, so there is no range.
    """

    name: ClassVar[str] = "encoder_quantization"
    stage: ClassVar[Stage] = "sensor"
    size: ClassVar[str] = "step"
    rank: ClassVar[int] = 1
    signatures: ClassVar[tuple[str, ...]] = ("encoder_steps",)
    as_noise: ClassVar[bool] = True
    fingerprint: ClassVar[str] = "measured positions are multiples of a step, and slow motion is a staircase"

    step: float = Field(0.0, ge=0.0, description="distance of two measurements, of the motor coordinate [rad or m]")

    @property
    def noise(self) -> float:
        """Half a step [rad or m]."""
        return self.step / 2

    def read(self, position: ca.SX, angle: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Round to the nearest multiple."""
        del angle
        step = ca.SX(values["step"])
        divisor = ca.if_else(step > 0, step, 1)
        return ca.if_else(step > 0, ca.floor(position / divisor + 0.5) * divisor, position)
