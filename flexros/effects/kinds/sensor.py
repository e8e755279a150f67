"""Effects in a motor's encoder."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.motor_law import AbstractMotorLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    import casadi as ca

    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class AbstractSensor(AbstractMotorLaw):
    """A change of the encoder's measurement. Several at one motor act in series, in order of `rank`.

    A member provides `name`, `stage`, `size`, `rank`, its parameters and `read`.
    """

    rank: ClassVar[int]
    """Order between motor and log: periodic errors 0, quantization 1."""

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors."""
        return robot.joint_names

    def constant_error(self) -> float:
        """Return by how much the measurement is off wherever the motor is [rad or m]: a prediction begins there."""
        return 0.0

    @abstractmethod
    def read(self, position: ca.SX, angle: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Return the measured motor position [rad or m], SX (1, 1).

        Args:
            position: Motor position with noise and the errors of lower rank [rad or m], SX.
            angle: True motor position on the rotor side of the gear [rad or m], SX.
            values: Value or symbol of every parameter of the effect, by name.
        """
