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
    """A change of what an encoder tells. Several at one motor act one after the other, by `rank`.

    A member provides `name`, `stage`, `size`, `rank`, its parameters and `read`.
    """

    rank: ClassVar[int]
    """Place on the way from motor to log: periodic errors 0, quantization 1."""

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """List the motors."""
        return robot.joint_names

    @abstractmethod
    def read(self, position: ca.SX, angle: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Evaluate what is measured.

        Args:
            position: Motor position with noise and the errors of lower rank [rad or m], SX.
            angle: True motor position on the rotor's side of the gear [rad or m], SX.
            values: Number or symbol of every parameter of the effect by name.

        Returns:
            Measured motor position [rad or m], SX (1, 1).
        """
