"""Effects that are torques at a motor: what they have in common, and what a motor offers them."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from flexros.effects.base import AbstractEffect

if TYPE_CHECKING:
    from collections.abc import Mapping

    import casadi as ca

    from flexros.robot import Robot
    from flexros.robot.kinematics import Value


@dataclass(frozen=True)
class MotorState:
    """What a torque at a motor may depend on.

    Attributes:
        position: Motor coordinate, on the side of the gear that the robot file uses [rad or m], SX.
        angle: The same on the rotor's side: gear ratio times the position where the file states the arm's side
            [rad or m], SX.
        speed: Rate of the motor coordinate [rad/s or m/s], SX.
        torque: Commanded torque that acts now, disturbances included [Nm or N], SX.
    """

    position: ca.SX
    angle: ca.SX
    speed: ca.SX
    torque: ca.SX


class AbstractMotorLaw(AbstractEffect):
    """An effect with a law of its own at a motor.

    Its parameters enter the plant as numbers or, where a batch varies them, as symbols.
    """

    size: ClassVar[str]
    """The parameter that switches the effect off when it is zero."""

    @property
    def neutral(self) -> bool:
        """Whether the effect is switched off, so that it is left out of the plant."""
        return bool(getattr(self, self.size) == 0)

    @property
    def numbers(self) -> dict[str, float]:
        """Parameters of the law that are plain numbers, by name."""
        dumped = self.model_dump()
        return {
            name: float(dumped[name]) for name, field in type(self).model_fields.items() if field.annotation is float
        }


class AbstractMotorTorque(AbstractMotorLaw):
    """A torque at a motor without jumps: it is part of the derivative of the state.

    A member provides `name`, `stage`, `size`, its parameters and `added`.
    """

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """List the motors."""
        return robot.joint_names

    @abstractmethod
    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Evaluate the law.

        Args:
            motor: State of the motor.
            values: Number or symbol of every parameter of the effect by name.

        Returns:
            Torque that is added at the motor [Nm or N], SX (1, 1).
        """
