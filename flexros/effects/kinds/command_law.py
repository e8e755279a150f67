"""Effects on the torque on its way from the command to the motor: saturation, then gain, then lag.

The delay of the command comes before them. Disturbance torques of a scenario enter with the command, before them too.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

import casadi as ca

from flexros.effects.kinds.motor_law import AbstractMotorLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class AbstractCommandLaw(AbstractMotorLaw):
    """A change of the torque between command and motor. Several at one motor act one after the other, by `rank`.

    A member provides `name`, `stage`, `size`, `rank`, its parameters and `passed`; with memory also
    `stepwise_states`, `before_step` and `rest`.
    """

    rank: ClassVar[int]
    """Place on the way from command to motor: saturation 0, gain 1, lag 2."""
    plain: ClassVar[bool] = True
    cuts_off: ClassVar[bool] = False
    """Whether it limits the command, by `cut_off`. A predictor with a delay does that to the recorded samples first:
    the filter of a delay by part of a sample is right only for torques that nothing cuts off behind it."""

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """List the motors."""
        return robot.joint_names

    @abstractmethod
    def passed(self, torque: ca.SX, own: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Evaluate the torque that comes out, through an integration step in which it is held.

        Args:
            torque: Torque that goes in [Nm or N], SX.
            own: Own states, as left by `before_step`, SX (n_states, 1).
            values: Number or symbol of every parameter of the effect by name.

        Returns:
            Torque [Nm or N], SX (1, 1).
        """

    def cut_off(self, torque: FloatArray) -> FloatArray:
        """Limit recorded commands [Nm or N]; only where `cuts_off`."""
        return torque

    def before_step(self, torque: ca.SX, own: ca.SX, values: Mapping[str, Value], step: ca.SX) -> ca.SX:
        """Update the own states before an integration step.

        Args:
            torque: Torque that goes in during the step [Nm or N], SX.
            own: Own states, SX (n_states, 1).
            values: Number or symbol of every parameter of the effect by name.
            step: Length of the step [s], SX.

        Returns:
            Own states, SX (n_states, 1).
        """
        del torque, values, step
        return own

    def rest(self, torque: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Give the own states after a torque has been going in for ever.

        Args:
            torque: That torque [Nm or N], SX.
            values: Number or symbol of every parameter of the effect by name.

        Returns:
            Own states, SX (n_states, 1).
        """
        del torque, values
        return ca.SX.zeros(self.n_states)
