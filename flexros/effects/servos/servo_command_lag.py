"""Filter of the commands of a servo."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.first_order_lag import AbstractFirstOrderLag
from flexros.effects.kinds.ranges import Range
from flexros.effects.kinds.servo_number import servo_motors

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class ServoCommandLag(AbstractFirstOrderLag):
    """A filter of first order between commanded position u and the position y that a servo follows: T dy/dt = u - y.

    Position actuators of MuJoCo have it as `timeconst`, hobby servos as smoothing of their input. A feedforward follows
    the filtered command. It acts, and is sought, where positions are commanded. Integration: `first_order_lag`, exact
    for commands that are held from sample to sample but for the line that approximates them.
    """

    name: ClassVar[str] = "servo_command_lag"
    stage: ClassVar[Stage] = "actuator"
    sought_where: ClassVar[str] = "in logs with position commands"
    rank: ClassVar[int] = -1
    filters_positions: ClassVar[bool] = True
    signatures: ClassVar[tuple[str, ...]] = ("time_shift", "effective_torque")
    fingerprint: ClassVar[str] = (
        "the motor comes late by the same time in slow and fast motion, rounds the corners of its command, and is in "
        "place where the command rests"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"time_constant": Range("time", 1e-5, 0.1, starts=5, widest=1.0, source="chosen")}
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors with a servo."""
        return servo_motors(robot)

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether the robot is commanded by positions."""
        del location
        return robot.commands == "position"
