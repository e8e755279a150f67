"""Error of the torque constant of a motor."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    import casadi as ca

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class TorqueGainError(AbstractCommandLaw):
    """The motor produces 1 + relative times the commanded torque.

    It scales stiffness, damping and limit of a servo alike. In logs of positions it is named in place of errors of both
    gains that it explains alone: its difference from a wrong stiffness is the damping.
    """

    name: ClassVar[str] = "torque_gain_error"
    stage: ClassVar[Stage] = "actuator"
    size: ClassVar[str] = "relative"
    rank: ClassVar[int] = 1
    signatures: ClassVar[tuple[str, ...]] = ("effective_torque", "torque_over_acceleration", "frequency_response")
    fingerprint: ClassVar[str] = (
        "a disturbance torque proportional to the command at all speeds, accelerations and positions"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "relative": Range(
                "relative",
                0.003,
                0.9,
                starts=2,
                signed=True,
                negative=0.63,
                widest=9.0,
                source="torque constants drop by 10 % hot; a wrong unit or gear ratio is far more; a torque of which "
                "less than 1 / 2.7 counts, as for the check of units, does not explain the motion",
            )
        }
    )

    relative: float = Field(0.0, gt=-1.0, lt=10.0, description="deviation of the torque from the commanded one [1]")

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether torques are commanded; for servos it follows from the errors of their gains."""
        del location
        return robot.commands == "torque"

    @property
    def gain(self) -> float:
        """Torque of the motor over the commanded one [1]."""
        return 1.0 + self.relative

    def passed(self, torque: ca.SX, own: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Return the scaled torque."""
        del own
        return (1 + values["relative"]) * torque
