"""Effects on the arm as a whole: forces on all arm coordinates, such as those of a mass on a spring at the tool."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.effects.kinds.law import AbstractLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value
    from flexros.robot.symbolic.model import SymbolicModel


@dataclass(frozen=True)
class ArmState:
    """State and parameters that a law of the arm may depend on.

    Attributes:
        position: Arm coordinates [rad or m], SX (N, 1).
        speed: Their rates, SX (N, 1).
        motor_position: Coordinates of the motors behind flexible gears [rad or m], SX (number of them, 1).
        motor_speed: Their rates.
        model: Symbolic model of the robot, e.g. `model.tool_pose(position, parameters)`.
        parameters: Their argument p.
        robot: The robot, for its nominal parameter values.
        location: Location of the law.
        own: States of the law itself, SX (smooth_states, 1).
    """

    position: ca.SX
    speed: ca.SX
    motor_position: ca.SX
    motor_speed: ca.SX
    model: SymbolicModel
    parameters: ca.SX
    robot: Robot
    location: str
    own: ca.SX

    @classmethod
    def of_arm(
        cls, robot: Robot, location: str, position: ca.SX, speed: ca.SX, model: SymbolicModel, parameters: ca.SX
    ) -> ArmState:
        """Return the state for a law without own states, of an arm whose gears do not bend.

        Args:
            robot: The robot.
            location: Location of the law.
            position: Arm coordinates [rad or m], SX (N, 1).
            speed: Their rates, SX (N, 1).
            model: Symbolic model of the robot.
            parameters: Its argument p.
        """
        motors = ca.SX.zeros(model.n_coordinates - model.n_arm)
        return cls(position, speed, motors, motors, model, parameters, robot, location, ca.SX(0, 1))

    def parameter(self, name: str) -> Value:
        """Return the value or symbol of a parameter of the robot."""
        if name in self.model.parameter_names:
            return self.parameters[self.model.parameter_names.index(name)]
        return self.robot.parameters[name].value


class AbstractArmLaw(AbstractLaw):
    """A law that adds generalised forces on the arm coordinates or on all coordinates; its own states are smooth.

    A member provides `name`, `stage`, `size`, its parameters, `locations` and `force`, with own states `rates`, and
    `rest` unless they start at zero.
    """

    @abstractmethod
    def force(self, arm: ArmState, values: Mapping[str, Value]) -> ca.SX:
        """Evaluate the law.

        Args:
            arm: State of the arm.
            values: Value or symbol of every parameter of the effect, by name.

        Returns:
            Additional generalised force on the arm coordinates [Nm or N], SX (N, 1), or on all coordinates
            q = [q_a, q_m], SX (n_coordinates, 1).
        """

    def rates(self, arm: ArmState, values: Mapping[str, Value]) -> ca.SX:
        """Return the derivatives of the own states, SX (smooth_states, 1); arguments as for `force`."""
        del arm, values
        return ca.SX.zeros(self.smooth_states)

    def rest(self, arm: ArmState, values: Mapping[str, Value]) -> ca.SX:
        """Return the initial own states, moving with the arm, SX (n_states, 1); `arm.own` must not be used."""
        del arm, values
        return ca.SX.zeros(self.n_states)
