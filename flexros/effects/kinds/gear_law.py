"""Effects in a spring: between motor and arm of a gear, or in a passive direction of the arm."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import casadi as ca

from flexros.effects.kinds.law import AbstractLaw

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


@dataclass(frozen=True)
class GearState:
    """State and parameters that a law of a spring may depend on.

    In a passive direction the motor side is the body before: the deflection is minus the arm coordinate, angle, motor
    speed and turns are zero, and a torque on the motor side has no effect. Where several laws act on one spring, each
    gets the state as changed by those of lower rank.

    Attributes:
        deflection: Motor minus arm coordinate [rad or m], SX.
        rate: Its derivative [rad/s or m/s], SX.
        angle: Motor coordinate on the rotor's side of the gear [rad or m], SX.
        motor_speed: Rate of the motor coordinate [rad/s or m/s], SX.
        turns: Rotor angle per motor coordinate: the gear ratio where the robot file states the arm's side, else 1.
        torque: Torque of spring and damper, from motor to arm [Nm or N], SX.
        damping: Damper [Nm s/rad or N s/m].
        spring: Torque of the spring [Nm or N] at any deflection.
        own: States of the law itself, smooth ones first, SX (n_states, 1).
        lever: Torque back on the motor, relative to the one on the arm [1]; 1 for an ideal gear.
    """

    deflection: ca.SX
    rate: ca.SX
    angle: ca.SX
    motor_speed: ca.SX
    turns: float
    torque: ca.SX
    damping: Value
    spring: Callable[[ca.SX], ca.SX]
    own: ca.SX
    lever: ca.SX | float = 1.0

    def transmits(self, change: ca.SX) -> GearTorques:
        """Return the torques of a law that changes the transmitted torque by `change` [Nm or N]."""
        return GearTorques(change, -change * self.lever)


@dataclass(frozen=True)
class GearTorques:
    """Torques that a law adds to those of the nominal spring and damper.

    A law that changes the transmitted torque adds T on the arm side and -T on the motor side, see
    `GearState.transmits`.

    Attributes:
        arm: Torque on the arm coordinate [Nm or N], SX.
        motor: Torque on the motor coordinate [Nm or N], SX.
    """

    arm: ca.SX
    motor: ca.SX


class AbstractGearLaw(AbstractLaw):
    """A law of a spring that adds torques at both ends.

    A member provides `name`, `stage`, `size`, `rank`, its parameters and `added`, with smooth own states `rates`, with
    stepwise ones `before_step` or `after_step`, and `rest` unless its states start at zero; a member that changes
    deflection or spring for the laws of higher rank also `onward`. By default it acts on the gears, named by their
    motors; with `locations` overridden on any spring, named as "body_2.ry" (with or without motor).
    """

    rank: ClassVar[int]
    """Order among the laws of one spring: shift of the deflection 0, form of the spring 1, backlash 2, parallel 3."""
    holds_deflection: ClassVar[bool] = False
    """Whether its own states are deflections, which a predictor corrects together with motor and arm."""

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors behind flexible gears."""
        return tuple(robot.joint_names[motor] for motor in robot.flexible_motors)

    @abstractmethod
    def added(self, gear: GearState, values: Mapping[str, Value]) -> GearTorques:
        """Return the additional torques.

        Args:
            gear: State of the spring.
            values: Value or symbol of every parameter of the effect, by name.
        """

    def onward(self, gear: GearState, values: Mapping[str, Value]) -> GearState:
        """Return the state passed to the laws of higher rank; arguments as for `added`."""
        del values
        return gear

    def rates(self, gear: GearState, values: Mapping[str, Value]) -> ca.SX:
        """Return the derivatives of the smooth own states, SX (smooth_states, 1); arguments as for `added`."""
        del gear, values
        return ca.SX.zeros(self.smooth_states)

    def before_step(self, gear: GearState, values: Mapping[str, Value], step: ca.SX) -> ca.SX:
        """Update the stepwise own states before an integration step.

        Args:
            gear: State of the spring at the start of the step.
            values: Value or symbol of every parameter of the effect, by name.
            step: Length of the step [s], SX.

        Returns:
            Stepwise states, SX (stepwise_states, 1).
        """
        del values, step
        return gear.own[self.smooth_states :]

    def after_step(self, gear: GearState, values: Mapping[str, Value], step: ca.SX) -> ca.SX:
        """Update the stepwise own states after an integration step from the state at its end; else as `before_step`."""
        del values, step
        return gear.own[self.smooth_states :]

    def rest(self, gear: GearState, values: Mapping[str, Value]) -> ca.SX:
        """Return the own states of a robot at rest, SX (n_states, 1).

        Args:
            gear: State of the spring, with rates of zero; its `own` must not be used.
            values: Value or symbol of every parameter of the effect, by name.
        """
        del gear, values
        return ca.SX.zeros(self.n_states)
