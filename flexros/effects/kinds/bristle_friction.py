"""Friction by bristles: a dry friction that deflects like a spring before it slides.

Over an integration step the friction torque is held at its mean, as in `dry_friction`. The bristle moves with the mean
speed of the motor, which depends on the torque: one implicit equation per motor and step. For a constant mean speed the
law of the bristle, dz/dt = v - s0 |v| z / g, is solved exactly, so that fast sliding of a stiff bristle does not make
the equation stiff. A bristle that is stiff against the motor's inertia, K = s0 h^2 / J, is integrated by a theta
method: order two for small K, damped like implicit Euler for large K, with the limit of dry friction.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import casadi as ca

from flexros.effects.kinds.motor_law import AbstractMotorLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value

STIFF = 12.0
"""K = s0 h^2 / J at which the method is midway between trapezoidal rule and implicit Euler [1] (chosen)."""
PASSES = 4
"""Newton steps for the mean speed of a step, starting from a linear spring with a limited torque (chosen)."""
_SMALL = 0.02
_STILL = 1e-12


@dataclass(frozen=True)
class Bristle:
    """Parameters of a bristle at a speed.

    Attributes:
        level: Torque g of steady sliding at this speed [Nm or N], SX.
        stiffness: s0 [Nm/rad or N/m].
        damping: s1 [Nm s/rad or N s/m].
    """

    level: ca.SX
    stiffness: Value
    damping: Value


class AbstractBristleFriction(AbstractMotorLaw):
    """Friction at a motor with presliding. Its own states are the bristle's deflection and the torque of the step.

    A member provides `name`, `stage`, `size`, its parameters and `bristle`.
    """

    stepwise_states = 2

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors."""
        return robot.joint_names

    @abstractmethod
    def bristle(self, speed: ca.SX, values: Mapping[str, Value]) -> Bristle:
        """Evaluate the parameters of the bristle; they are held through a step.

        Args:
            speed: Rate of the motor coordinate [rad/s or m/s], SX.
            values: Value or symbol of every parameter of the effect, by name.
        """


def bristle_step(
    deflection: ca.SX, speed: ca.SX, acceleration: ca.SX, mobility: ca.SX, bristle: Bristle, step: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """Advance a bristle by one step.

    Args:
        deflection: Initial deflection z [rad or m].
        speed: Initial speed v of the motor [rad/s or m/s].
        acceleration: Acceleration a of the motor without this friction, half a step ahead [rad/s2 or m/s2].
        mobility: Acceleration per torque at the motor [1/(kg m2) or 1/kg].
        bristle: Its parameters.
        step: Length h of the step [s].

    Returns:
        Final deflection [rad or m] and friction torque of the step [Nm or N], positive against a positive speed.
    """
    stiffness, damping = ca.SX(bristle.stiffness), ca.SX(bristle.damping)
    level = ca.fmax(bristle.level, _STILL)
    K = stiffness * mobility * step**2
    theta = 0.5 + 0.5 * K / (K + STIFF)
    reach = theta * step  # up to the instant whose speed moves the bristle
    free = speed + reach * acceleration
    elastic = (stiffness * (deflection + reach * free) + damping * free) / (
        1 + reach * mobility * (stiffness * reach + damping)
    )
    mean = free - reach * mobility * ca.fmin(ca.fmax(elastic, -level), level)
    move, improve = _equation()
    constants = (deflection, step, stiffness, damping, level, theta)
    for _ in range(PASSES):
        mean = improve(mean, *constants, free, reach * mobility)
    end, torque = move(mean, *constants)
    return end, torque


@cache
def _equation() -> tuple[ca.Function, ca.Function]:
    """Build the functions of a step: mean speed -> final deflection and torque, and a Newton step for the speed."""
    symbols = [ca.SX.sym(name) for name in ("mean", "z", "h", "s0", "s1", "g", "theta", "free", "yielding")]
    mean, deflection, step, stiffness, damping, level, theta, free, yielding = symbols
    decay, average, rise = _slip_factors(stiffness * ca.fabs(mean) / level * step)
    end = deflection * decay + mean * step * average
    middle = deflection * average + mean * step * rise
    torque = stiffness * ((2 - 2 * theta) * middle + (2 * theta - 1) * end) + damping * (end - deflection) / step
    move = ca.Function("move", symbols[:7], [end, torque])
    residual = mean - free + yielding * torque
    # with a held level friction grows with speed, so the slope is at least one
    better = mean - residual / ca.fmax(ca.jacobian(residual, mean), 1)
    return move, ca.Function("improve", symbols, [better])


def _slip_factors(x: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return exp(-x), (1 - exp(-x)) / x and the mean of that over a step, (x - 1 + exp(-x)) / x^2, for x >= 0."""
    large = ca.fmax(x, _SMALL)
    decay = ca.exp(-x)
    average = ca.if_else(x > _SMALL, (1 - decay) / large, 1 - x / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5))))
    rise = ca.if_else(x > _SMALL, (large - 1 + decay) / large**2, 0.5 - x / 6 * (1 - x / 4 * (1 - x / 5 * (1 - x / 6))))
    return decay, average, rise
