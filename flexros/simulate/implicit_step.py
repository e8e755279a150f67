"""Integration step of arms whose servos or viscous friction are much faster than a sample.

A Runge-Kutta step must be shorter than 2.8 time constants of the fastest motion, however little of it shows. The light
wrist of a URDF without rotors, held by a servo, has time constants of microseconds. The step here is linearly implicit
in the stiffness K and the damping D of every motor, both diagonal, and explicit in all else (Verwer et al. 1999, "A
second-order Rosenbrock method applied to photochemical dispersion problems"; a W-method: of order two for any
K and D):

    (1 - g h A) k1 = h f(x),   (1 - g h A) k2 = h f(x + k1) - 2 k1,   x <- x + 3/2 k1 + 1/2 k2,   g = 1 - 1/sqrt(2)

With A = [0 1; -M^-1 K, -M^-1 D] the accelerations of a stage are those of an arm with the additional inertias
g h D + (g h)^2 K at its motors, under a torque that depends on the stage.

Stages go up to 1 / g times as far as the step. A servo that holds a light joint seems to be beyond its torque limit
there, or at the beginning of a log whose speed is not known yet, although it is not for longer than microseconds. So
whether it is at its limit in a step decides the torque that is left at x + g k1 without one.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.loop.functions import N_WEIGHTS
from flexros.simulate.motor_stiffness import MotorStiffness, motor_stiffness
from flexros.simulate.plant_rates import acting_torque, rates_beside_motion
from flexros.simulate.stages import Stages

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.simulate.plant_symbols import PlantSymbols

GAMMA = 1 - 1 / math.sqrt(2)
"""Coefficient of the implicit terms [1]: motions that are much faster than a step are gone after it."""


def implicit_step(plant: PlantSymbols) -> ca.Function:
    """Build (x, u, w, p, weights) -> x one step later; u, w and p are held, and the first weight is its length [s].

    Args:
        plant: Symbols of a rigid plant.
    """
    weights = ca.SX.sym("weights", N_WEIGHTS)
    arguments = [plant.x, plant.u, plant.w, plant.p, weights]
    stages, h = Stages(arguments), weights[0]
    ahead, motors, n = GAMMA * h, list(plant.robot.motor_rows), plant.model.n_coordinates
    force = plant.added_force()
    added = ca.SX.zeros(n) if force is None else force
    others = rates_beside_motion(plant)

    def stage(x: ca.SX, carried: ca.SX, torque: Callable[[ca.SX], ca.SX], held: MotorStiffness) -> ca.SX:
        """Solve (1 - g h A) k = h f(x) + carried."""
        inertia = held.inertia(ahead)
        acting, forces, rates = torque(x), *(ca.substitute(value, plant.x, x) for value in (added, others))
        way, kick = h * x[n : 2 * n] + carried[:n], carried[n : 2 * n]
        acting -= ahead * held.stiffness * way[motors] + inertia * kick[motors] / h
        (acceleration,) = stages.call(
            plant.model.heavier_acceleration,
            *(x[:n], x[n : 2 * n], acting, plant.w, forces, plant.of_motors(inertia), plant.robot_parameters),
        )
        gained = h * acceleration + kick
        return ca.vertcat(way + ahead * gained, gained, h * rates + carried[2 * n :])

    free, limited = (acting_torque(plant, limited=answer) for answer in (False, True))
    nothing, held = ca.SX.zeros(plant.x.numel()), motor_stiffness(plant)

    def without_limits(x: ca.SX) -> ca.SX:
        return ca.substitute(free, plant.x, x)

    first, torque = stage(plant.x, nothing, without_limits, held), without_limits
    limits = ca.DM([motor.torque_limit for motor in plant.robot.motors])
    if plant.robot.commands == "position" and np.isfinite(limits).any():
        left = ca.substitute(plant.driven(plant.followed(plant.u), limited=False), plant.x, plant.x + GAMMA * first)
        at_limit, bound = ca.fabs(left) > limits, motor_stiffness(plant, limited=True)

        def within_limits(x: ca.SX) -> ca.SX:
            return ca.if_else(at_limit, ca.substitute(limited, plant.x, x), without_limits(x))

        stiffness = ca.if_else(at_limit, bound.stiffness, held.stiffness)
        held = MotorStiffness(stiffness, ca.if_else(at_limit, bound.damping, held.damping))
        torque = within_limits
        first = stage(plant.x, nothing, torque, held)
    second = stage(plant.x + first, -2 * first, torque, held)
    return stages.function("implicit_step", plant.x + 1.5 * first + 0.5 * second)
