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
FURTHER_PASSES = 1
"""The same starting from the mean speed beside other frictions of the step that have changed a little (chosen)."""
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


@dataclass(frozen=True)
class BristleStep:
    """What a bristle does in a step.

    Attributes:
        deflection: Final deflection [rad or m], SX.
        torque: Friction torque of the step [Nm or N], positive against a positive speed, SX.
        mean: Mean speed of the motor [rad/s or m/s], SX.
    """

    deflection: ca.SX
    torque: ca.SX
    mean: ca.SX


def bristle_step(
    deflection: ca.SX,
    speed: ca.SX,
    acceleration: ca.SX,
    mobility: ca.SX,
    bristle: Bristle,
    step: ca.SX,
    near: ca.SX | None = None,
) -> BristleStep:
    """Advance a bristle by one step.

    Args:
        deflection: Initial deflection z [rad or m].
        speed: Initial speed v of the motor [rad/s or m/s].
        acceleration: Acceleration a of the motor without this friction, half a step ahead [rad/s2 or m/s2].
        mobility: Acceleration per torque at the motor [1/(kg m2) or 1/kg].
        bristle: Its parameters.
        step: Length h of the step [s].
        near: Mean speed near that of the step [rad/s or m/s]; None where none is known.
    """
    stiffness, damping = ca.SX(bristle.stiffness), ca.SX(bristle.damping)
    level = ca.fmax(bristle.level, _STILL)
    K = stiffness * mobility * step**2
    theta = 0.5 + 0.5 * K / (K + STIFF)
    reach = theta * step  # up to the instant whose speed moves the bristle
    free = speed + reach * acceleration
    if near is None:
        elastic = (stiffness * (deflection + reach * free) + damping * free) / (
            1 + reach * mobility * (stiffness * reach + damping)
        )
        mean = free - reach * mobility * ca.fmin(ca.fmax(elastic, -level), level)
    else:
        mean = near
    at_middle, at_end, damper = (2 - 2 * theta) * stiffness, (2 * theta - 1) * stiffness, damping / step
    slip, yielding = stiffness * step / level, reach * mobility

    def moved_with(mean: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Return the final deflection, the torque, and the slope of the torque over a mean speed."""
        decay, average, rise, fall = _slip_factors(slip * ca.fabs(mean))
        end = deflection * decay + mean * step * average
        middle = deflection * average + mean * step * rise
        torque = at_middle * middle + at_end * end + damper * (end - deflection)
        slope = ((at_end + damper) * decay + at_middle * fall) * (step - ca.sign(mean) * slip * deflection)
        return end, torque, slope

    for _ in range(PASSES if near is None else FURTHER_PASSES):
        _, torque, slope = moved_with(mean)
        # with a held level friction grows with speed, so the slope is at least zero
        mean = mean - (mean - free + yielding * torque) / (1 + yielding * ca.fmax(slope, 0))
    end, torque, _ = moved_with(mean)
    return BristleStep(end, torque, mean)


def _slip_factors(x: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    """Return what bristles keep of their deflection, and of a motion, over a step in which they slip.

    Args:
        x: Slip s0 |v| h / g of the step [1], zero or more.

    Returns:
        At the end of the step, exp(-x) of a deflection and A = (1 - exp(-x)) / x of a motion. As means over the step, A
        of a deflection and (x - 1 + exp(-x)) / x^2 of a motion. Last, -dA/dx. Constants are multiplied, not divided by,
        since divisions take longest.
    """
    small = x <= _SMALL
    inverse = 1 / ca.fmax(x, _SMALL)
    decay = ca.exp(-x)
    average = ca.if_else(small, 1 - x * (1 / 2 - x * (1 / 6 - x * (1 / 24 - x * (1 / 120)))), (1 - decay) * inverse)
    rise = ca.if_else(small, 1 / 2 - x * (1 / 6 - x * (1 / 24 - x * (1 / 120))), (1 - average) * inverse)
    fall = ca.if_else(small, 1 / 2 - x * (1 / 3 - x * (1 / 8 - x * (1 / 30))), (average - decay) * inverse)
    return decay, average, rise, fall
