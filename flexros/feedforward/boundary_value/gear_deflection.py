"""Motors behind flexible gears: their motion from the torques that the arm requires."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.feedforward.time_stepping.dae_equations import motor_motion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot

NEWTON_STEPS = 12
"""Newton steps for the deflection at a sample; one suffices for a linear spring (chosen)."""


@dataclass(frozen=True, eq=False)
class GearDeflections:
    """Deflections of the flexible gears of a robot along given torques.

    Attributes:
        deflect: ([deflection, the one before], torque) -> the same one step later; deflections (number of flexible
            gears,) by the two-step backward difference formula for s(d) + D d' = tau.
        motion: (q_a, v_a, a_a, gear torques, deflections, their rates and accelerations) -> torque, load, momentum,
            encoder position and rate of all motors.
    """

    deflect: ca.Function
    motion: ca.Function

    def along(self, torques: FloatArray, start: FloatArray) -> FloatArray:
        """Compute the deflections at all samples, beginning at rest.

        Args:
            torques: Torques of the flexible gears [Nm or N], shape (n, number of them).
            start: Deflections in equilibrium before the first sample [rad or m], shape (number of them,).

        Returns:
            Deflections [rad or m], same shape as `torques`.
        """
        n, number = torques.shape
        if not number:
            return np.zeros((n, 0))
        states = self.deflect.mapaccum(n)(np.tile(start, 2), torques.T)
        return np.array(states, dtype=float).T[:, :number].copy()


@lru_cache(maxsize=8)
def gear_deflections(robot: Robot, step: float) -> GearDeflections:
    """Build the functions of a robot; they are built once and cached.

    Args:
        robot: The robot.
        step: Time step h [s].
    """
    model, n, p = robot.model, robot.n_arm, robot.model.parameter_values
    flexible = [robot.gear_rows[motor] for motor in robot.flexible_motors]
    number = len(flexible)
    state, torque = ca.SX.sym("state", 2 * number), ca.SX.sym("torque", number)
    d, d_1, d_2, rest = ca.SX.sym("d", number), state[:number], state[number:], ca.SX.zeros(n)
    rate = (1.5 * d - 2 * d_1 + 0.5 * d_2) / step
    error = model.transmission_force(rest, rest, d, rate, p)[flexible] - torque
    improved = d - error / ca.diag(ca.jacobian(error, d)) if number else d
    newton = ca.Function("newton", [d, state, torque], [improved])
    value = d_1
    for _ in range(NEWTON_STEPS if not _linear(robot) else 1):
        value = newton(value, state, torque)
    arm = [ca.SX.sym(name, n) for name in ("q_a", "v_a", "a_a")]
    gears = [ca.SX.sym(name, number) for name in ("deflection", "gear_rate", "gear_acceleration")]
    torques = ca.SX.sym("tau", robot.n_motors)
    u = ca.SX.zeros(robot.n_motors)
    for motor in robot.stiff_motors:
        u[motor] = torques[motor]
    q, v, a = (ca.vertcat(part, part[flexible] + own) for part, own in zip(arm, gears, strict=True))
    results = [ca.densify(ca.SX(part)) for part in motor_motion(model, q, v, a, u)]
    return GearDeflections(
        deflect=ca.Function("deflect", [state, torque], [ca.vertcat(value, d_1)], {"cse": True}),
        motion=ca.Function("motion", [*arm, torques, *gears], results, {"cse": True}),
    )


def _linear(robot: Robot) -> bool:
    """Return whether all flexible gears have linear springs."""
    springs = [robot.motors[motor].joint.direction.spring for motor in robot.flexible_motors]
    return all(spring is None or getattr(spring, "linear", False) for spring in springs)
