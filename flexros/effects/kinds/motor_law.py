"""Effects at a motor: their common base, smooth torques, and the motor state they depend on."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import casadi as ca

from flexros.effects.kinds.law import AbstractLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


@dataclass(frozen=True)
class MotorState:
    """State and parameters that a torque at a motor may depend on.

    Attributes:
        position: Motor coordinate, on the side of the gear that the robot file uses [rad or m], SX.
        angle: The same on the rotor side: gear ratio times the position where the file states the arm side
            [rad or m], SX.
        speed: Rate of the motor coordinate [rad/s or m/s], SX.
        torque: Torque of the motor, after saturation, gain and lag, disturbances included [Nm or N], SX.
        own: Own states of the law, SX (n_states, 1).
        viscous_friction: Nominal viscous friction of the motor [Nm s/rad or N s/m].
        load: Torque that its gear transmits to the arm [Nm or N], SX; given to dry friction only, in the middle of a
            step.
    """

    position: ca.SX
    angle: ca.SX
    speed: ca.SX
    torque: ca.SX
    own: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    viscous_friction: Value = 0.0
    load: ca.SX = field(default_factory=lambda: ca.SX(0))


class AbstractMotorLaw(AbstractLaw):
    """An effect with a law at a motor."""

    def rates(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Return the derivatives of the smooth own states, SX (smooth_states, 1); arguments as for `added`."""
        del motor, values
        return ca.SX.zeros(self.smooth_states)


class AbstractMotorTorque(AbstractMotorLaw):
    """A continuous torque at a motor, part of the derivative of the state.

    A member provides `name`, `stage`, `size`, its parameters and `added`, and `rates` where it has states of its own.
    """

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors."""
        return robot.joint_names

    @abstractmethod
    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Return the additional torque at the motor [Nm or N], SX (1, 1), linear in `motor.torque`.

        Args:
            motor: State of the motor.
            values: Value or symbol of every parameter of the effect, by name.
        """
