"""Dry friction at a motor: base class, and its mean torque over an integration step.

Dry friction jumps with the sign of the speed, and at standstill it takes the value that holds the motor. Neither is a
function of the state that Runge-Kutta steps can integrate. The friction torque of a step is therefore computed before
it, from the exact motion of the motor under the present acceleration, and held during the step as a state of its own:

- A motor that slides through the step gets exactly its level, and the step keeps order four.
- A motor that stops or reverses within the step gets the mean of its friction torque over the step. The instants of
  stopping and starting are exact but for the change of the other torques within the step: order two.
- A motor at rest under less torque than the level gets exactly the opposite torque and stays at rest. It does not
  creep, as it would with a smoothed sign, nor drift, as it would with Strang splitting of the friction.

The torques against the friction are extrapolated to a third of the step by the rate of the springs. With this choice a
motor that sticks under the torque of an oscillating arm neither dissipates nor supplies energy: at angular frequency w
and step h the work per cycle is proportional to (1/3 - share ahead) (w h)^2, from the mean of torque times speed over a
step. Under torques that change by D the sticking motor moves by about D h^2 / (12 J), and back again.
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
"""Instant in a step at which the torques against the friction are evaluated [share of the step]; see above."""


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
    """Friction at a motor with sticking. The levels of several at one motor add.

    A member provides `name`, `stage`, `size`, its parameters and `levels`.
    """

    eases: ClassVar[bool] = False
    """Whether its levels may be negative, which reduces the other dry frictions of the motor, at most to zero."""

    depends_on_speed: ClassVar[bool] = False
    """Whether its levels, or a torque beside them, follow a curve over the speed."""

    needs_load: ClassVar[bool] = False
    """Whether its levels depend on the torque that the gear transmits, `MotorState.load`."""

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors."""
        return robot.joint_names

    reduces: ClassVar[bool] = False
    """Whether its levels may be negative beside another one of its kind at the motor."""

    @abstractmethod
    def levels(self, motor: MotorState, values: Mapping[str, Value]) -> FrictionLevels:
        """Return the levels, which are held through the step.

        Args:
            motor: State of the motor in the middle of a step.
            values: Value or symbol of every parameter of the effect, by name.
        """


def mean_friction(speed: ca.SX, acceleration: ca.SX, mobility: ca.SX, levels: FrictionLevels, step: ca.SX) -> ca.SX:
    """Compute the mean friction torque over a step, from the exact motion under a constant torque.

    Args:
        speed: Initial speed v [rad/s or m/s].
        acceleration: Acceleration a of the motor without its friction, `AHEAD` in the step [rad/s2 or m/s2].
        mobility: Acceleration per torque at the motor, 1/J for a motor behind a spring [1/(kg m2) or 1/kg].
        levels: Levels of the friction.
        step: Length h of the step [s].

    Returns:
        Torque f [Nm or N], positive against a positive speed: the acceleration of the step is a - mobility f.
    """
    one = _stopping(speed, acceleration, mobility, levels, step)
    mean = (one.acceleration - (one.after - one.speed) / step) / mobility
    return one.direction * ca.if_else(one.slides, one.against, mean)


def way_beside_mean(speed: ca.SX, acceleration: ca.SX, mobility: ca.SX, levels: FrictionLevels, step: ca.SX) -> ca.SX:
    """Compute how much farther a motor gets in a step than under the mean of its friction torque [rad or m].

    The motor stops within the step, so that its friction jumps there; arguments as of `mean_friction`.
    """
    one = _stopping(speed, acceleration, mobility, levels, step)
    lacking = 0.5 * (one.speed * (step - one.stop) + one.after * one.stop)
    return ca.if_else(one.slides, 0.0, -one.direction * lacking)


@dataclass(frozen=True)
class _Stopping:
    """Motion of a motor in a step, in the direction in which it begins.

    Attributes:
        direction: Sign of the initial speed.
        speed: Initial speed.
        acceleration: Acceleration without friction.
        against: Level of the friction that brakes.
        slides: Whether it does not stop within the step.
        stop: Time until it stops [s], where it does.
        after: Speed at the end, where it stops before.
    """

    direction: ca.SX
    speed: ca.SX
    acceleration: ca.SX
    against: ca.SX
    slides: ca.SX
    stop: ca.SX
    after: ca.SX


def _stopping(speed: ca.SX, acceleration: ca.SX, mobility: ca.SX, levels: FrictionLevels, step: ca.SX) -> _Stopping:
    backward = speed < 0
    direction = ca.if_else(backward, -1.0, 1.0)
    against = ca.if_else(backward, levels.backward, levels.forward)
    reverse = ca.if_else(backward, levels.forward, levels.backward)
    v, a = direction * speed, direction * acceleration
    braked = a - mobility * against
    slides = v + step * braked >= 0
    stop = v / ca.if_else(slides, 1.0, -braked)  # not used where it slides
    after = ca.fmin(a + mobility * reverse, 0) * (step - stop)
    return _Stopping(direction, v, a, against, slides, stop, after)
