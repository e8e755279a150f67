"""Dry friction at a motor: what all kinds have in common, and the mean torque of one over an integration step.

Dry friction jumps with the sign of the speed, and at standstill it takes the value that keeps the motor still. Neither
is a function of the state that Runge-Kutta steps could follow. So the friction torque of a step is computed before it,
from the exact motion of the motor under the present acceleration, and held during the step as a state of its own:

- A motor that slides through the step has exactly its level, and the step keeps the order four.
- A motor that stops and turns round within the step has the mean of its friction torque over the step, the instants of
  stopping and starting exact but for the change of the other torques in it: order two.
- A motor at rest under less torque than the level has exactly the opposite torque: it stays where it is. It does not
  creep, as it would with a smoothed sign, nor drift, as it would with the friction split off the rest (Strang).

The torques that count are those a third of the step ahead, as far as the turning of springs tells them. With this
choice a motor that sticks under the torque of a swinging arm neither takes energy from it nor gives it any: at angular
frequency w and step h the work per cycle is proportional to (1/3 - share ahead) (w h)^2, from the mean of torque times
speed over a step. Under torques that change by D the sticking motor moves by some D h^2 / (12 J), and back again.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import casadi as ca

from flexros.effects.kinds.motor_law import AbstractMotorLaw, MotorState

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


AHEAD = 1 / 3
"""Instant in a step at which the torques against the friction are taken [share of the step]; see above."""


@dataclass(frozen=True)
class FrictionLevels:
    """Size of the friction torque in the two directions.

    Attributes:
        forward: Against a positive speed [Nm or N], not negative, SX.
        backward: Against a negative speed [Nm or N], not negative, SX.
    """

    forward: ca.SX
    backward: ca.SX

    def __add__(self, other: FrictionLevels) -> FrictionLevels:
        """Add the levels of two effects at one motor."""
        return FrictionLevels(self.forward + other.forward, self.backward + other.backward)


class AbstractDryFriction(AbstractMotorLaw):
    """A friction at a motor that can stick. Several at one motor add their levels.

    A member provides `name`, `stage`, `size`, its parameters and `levels`.
    """

    eases: ClassVar[bool] = False
    """Whether its levels may be negative, which eases the other frictions of the motor, down to none."""

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """List the motors."""
        return robot.joint_names

    @abstractmethod
    def levels(self, motor: MotorState, values: Mapping[str, Value]) -> FrictionLevels:
        """Evaluate the levels.

        Args:
            motor: State of the motor in the middle of a step.
            values: Number or symbol of every parameter of the effect by name.

        Returns:
            The levels in this state; they hold through the step.
        """


def mean_friction(speed: ca.SX, acceleration: ca.SX, mobility: ca.SX, levels: FrictionLevels, step: ca.SX) -> ca.SX:
    """Compute the mean friction torque over a step, from the exact motion under a constant torque.

    Args:
        speed: Speed v at the begin of the step [rad/s or m/s].
        acceleration: Acceleration a of the motor without its friction, `AHEAD` in the step [rad/s2 or m/s2].
        mobility: Acceleration per torque at the motor, 1/J for a motor behind a spring [1/(kg m2) or 1/kg].
        levels: Levels of the friction.
        step: Length h of the step [s].

    Returns:
        Torque f [Nm or N], positive against a positive speed: the acceleration of the step is a - mobility f.
    """
    backward = speed < 0
    direction = ca.if_else(backward, -1.0, 1.0)
    against = ca.if_else(backward, levels.backward, levels.forward)
    reverse = ca.if_else(backward, levels.forward, levels.backward)
    v, a = direction * speed, direction * acceleration  # in the direction of motion
    braked = a - mobility * against
    slides = v + step * braked >= 0
    stop = v / ca.if_else(slides, 1.0, -braked)  # not used where it slides
    after = ca.fmin(a + mobility * reverse, 0) * (step - stop)
    return direction * ca.if_else(slides, against, (a - (after - v) / step) / mobility)
