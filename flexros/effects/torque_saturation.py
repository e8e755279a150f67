"""Torque limit of a motor."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
import numpy as np
from pydantic import Field

from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.effects.kinds.base import Stage
    from flexros.robot.symbolic.kinematics import Value


class TorqueSaturation(AbstractCommandLaw):
    """The torque of the motor is limited in both directions, whatever the command.

    The limits known to the controller are separate and unchanged. A limit of zero means no limit: it switches the
    effect off.
    """

    name: ClassVar[str] = "torque_saturation"
    stage: ClassVar[Stage] = "actuator"
    size: ClassVar[str] = "limit"
    rank: ClassVar[int] = 0
    signatures: ClassVar[tuple[str, ...]] = ("effective_torque", "detection_lines")
    cuts_off: ClassVar[bool] = True
    fingerprint: ClassVar[str] = (
        "no disturbance torque up to a level of the command, and beyond it the excess of the command over that level"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"limit": Range("torque", 0.1, 1.0, starts=(0.15, 0.3, 0.5, 0.7, 0.85, 0.95, 0.98, 0.995), vanishes="high")}
    )

    limit: float = Field(0.0, ge=0.0, description="largest torque either way [Nm or N]; 0: no limit")

    def passed(self, torque: ca.SX, own: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Return the limited torque."""
        del own
        limit = ca.SX(values["limit"])
        return ca.if_else(limit > 0, ca.fmin(ca.fmax(torque, -limit), limit), torque)

    def cut_off(self, torque: FloatArray) -> FloatArray:
        """Limit recorded commands."""
        return np.clip(torque, -self.limit, self.limit)
