"""Effects on the torque between command and motor: saturation, then gain, then lag.

Filters of commanded positions act before a servo makes the torque. The delay of the command precedes all of them.
Disturbance torques of a scenario are added to the command, also before them.
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
    """A change of the torque between command and motor. Several at one motor act in series, in order of `rank`.

    A member provides `name`, `stage`, `size`, `rank`, its parameters and `passed`; with own states also
    `stepwise_states`, `before_step` and `rest`.
    """

    rank: ClassVar[int]
    """Order between command and motor: filter of a commanded position -1, saturation 0, gain 1, lag 2."""
    filters_positions: ClassVar[bool] = False
    """Whether it acts on the commanded position of a servo [rad or m], before the torque that this makes."""
    plain: ClassVar[bool] = True
    cuts_off: ClassVar[bool] = False
    """Whether it limits the command, by `cut_off`. A predictor with a delay then limits the recorded samples first: the
    filter for a fractional delay is valid only for torques that are not clipped after it."""

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors."""
        return robot.joint_names

    @abstractmethod
    def passed(self, torque: ca.SX, own: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Return the output torque, held through an integration step.

        Args:
            torque: Input torque [Nm or N], SX.
            own: Own states, as left by `before_step`, SX (n_states, 1).
            values: Value or symbol of every parameter of the effect, by name.

        Returns:
            Torque [Nm or N], SX (1, 1).
        """

    @property
    def gain(self) -> float:
        """Torque of the motor over the commanded one, where they are proportional [1]."""
        return 1.0

    def cut_off(self, torque: FloatArray) -> FloatArray:
        """Limit recorded commands [Nm or N]; only where `cuts_off`."""
        return torque

    def before_step(self, torque: ca.SX, own: ca.SX, values: Mapping[str, Value], step: ca.SX) -> ca.SX:
        """Update the own states before an integration step.

        Args:
            torque: Input torque during the step [Nm or N], SX.
            own: Own states, SX (n_states, 1).
            values: Value or symbol of every parameter of the effect, by name.
            step: Length of the step [s], SX.

        Returns:
            Own states, SX (n_states, 1).
        """
        del torque, values, step
        return own

    def rest(self, torque: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Return the own states in steady state.

        Args:
            torque: Constant input torque [Nm or N], SX.
            values: Value or symbol of every parameter of the effect, by name.

        Returns:
            Own states, SX (n_states, 1).
        """
        del torque, values
        return ca.SX.zeros(self.n_states)
