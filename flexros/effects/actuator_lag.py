"""Lag of the current loop of a motor."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.first_order_lag import AbstractFirstOrderLag
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class ActuatorLag(AbstractFirstOrderLag):
    """A lag of first order between commanded torque u and torque of the motor y: T dy/dt = u - y.

    Integration: `first_order_lag`, of order four in the integration step.
    """

    name: ClassVar[str] = "actuator_lag"
    stage: ClassVar[Stage] = "actuator"
    rank: ClassVar[int] = 2
    signatures: ClassVar[tuple[str, ...]] = ("time_shift", "detection_lines")
    fingerprint: ClassVar[str] = (
        "prediction errors follow torque changes as for a delay, but the response also rolls off at high frequencies"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "time_constant": Range(
                "time", 1e-6, 0.02, starts=6, widest=0.2, source="current loops of 0.05 to 2 kHz; slow servos"
            )
        }
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors."""
        return robot.joint_names
