"""Equations 8a and 8d of Moberg (2007), Paper B, at all samples at once, with central differences for the rates."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.over_rows import over_rows
from flexros.feedforward.compensation.arm_forces import arm_forces
from flexros.feedforward.time_stepping.dae_equations import arm_residual
from flexros.feedforward.tool_geometry import ToolGeometry

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import PlacedLaw
    from flexros.robot import Robot

BLOCK = 512
"""Samples that are evaluated by one call (chosen: some megabytes of work space)."""


@dataclass(frozen=True, eq=False)
class KnownMotion:
    """What is known of the motion at n samples.

    Attributes:
        position: Arm coordinates of the rigid arm on the trajectory [rad or m], shape (n, N).
        velocity: Their rates [rad/s or m/s], same shape.
        acceleration: Their accelerations [rad/s^2 or m/s^2], same shape.
        output: Desired output [m or rad], shape (n, n_out).
        gear_rate: Rates of the deflections of flexible gears [rad/s or m/s], shape (n, number of them); zero but for
            rotors that act on the arm in addition to their gears (inertial coupling).
        gear_acceleration: Accelerations of these deflections, same shape.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    output: FloatArray
    gear_rate: FloatArray
    gear_acceleration: FloatArray

    def __len__(self) -> int:
        return len(self.position)

    def at_rest(self, sample: int) -> KnownMotion:
        """Return a single sample with all rates zero."""
        rows = [getattr(self, field.name)[[sample]] for field in fields(self)]
        position, velocity, acceleration, output, rate, gear_acceleration = rows
        return KnownMotion(position, 0.0 * velocity, 0.0 * acceleration, output, 0.0 * rate, 0.0 * gear_acceleration)


@dataclass(frozen=True, eq=False)
class DifferenceEquations:
    """Equations of one sample k in the unknowns of k - 1, k and k + 1, with a time step h.

    The unknowns x = [deflections e of q_a, gear torques tau], shape (N + M,), with q_r(t) the motion of the rigid arm,
    whose rates are exact:

        q_a = q_r + e_k,  v_a = q_r' + (e_{k+1} - e_{k-1}) / (2 h),  a_a = q_r'' + (e_{k+1} - 2 e_k + e_{k-1}) / h^2,
        M(q_a) a_a = c(q_a, v_a) + g(q_a) + elastic forces + tau in the geared directions,   Gamma(q_a) = Z_d.

    Differences of the small deflections alone keep round-off and the error of second order small. With the torques
    instead of the motor positions as unknowns the gears' dampers need no differences here.

    Attributes:
        n_arm: Number of arm coordinates N.
        n_unknowns: Number of unknowns per sample.
        step: Time step h [s].
        torque_units: Gear torques per unit of their unknowns [Nm or N], shape (M,).
        residual: (x, e', e'', q_r, q_r', q_r'', Z_d, gear rate, gear acceleration) -> residual (n_unknowns,).
        slopes: The same arguments -> derivatives of the residual by x, e' and e'', side by side, column by column.
    """

    n_arm: int
    n_unknowns: int
    step: float
    torque_units: FloatArray
    residual: ca.Function
    slopes: ca.Function

    @property
    def n_out(self) -> int:
        """Number of components of the output, whose equations come last."""
        return self.n_unknowns - self.n_arm

    def rates(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return e' and e'' of the inner samples of x, shape (n + 2, any number): two arrays (n, that number)."""
        return (x[2:] - x[:-2]) / (2 * self.step), (x[2:] - 2 * x[1:-1] + x[:-2]) / self.step**2

    def residuals(self, x: FloatArray, known: KnownMotion) -> FloatArray:
        """Evaluate the equations of all inner samples.

        Args:
            x: Unknowns, shape (n + 2, n_unknowns): one sample more than `known` at either end.
            known: Known motion, n samples.

        Returns:
            Residuals, shape (n, n_unknowns).
        """
        return self._evaluate(self.residual, x, known)

    def blocks(self, x: FloatArray, known: KnownMotion) -> FloatArray:
        """Evaluate the derivatives of the equations of k by the unknowns of k - 1, k and k + 1.

        Args:
            x: Unknowns, shape (n + 2, n_unknowns).
            known: Known motion, n samples.

        Returns:
            Derivatives, shape (3, n, n_unknowns, n_unknowns).
        """
        slopes = self._evaluate(self.slopes, x, known)
        nz, h = self.n_unknowns, self.step
        by_x, by_v, by_a = slopes.reshape(len(slopes), 3, nz, nz).transpose(1, 0, 3, 2)
        return np.stack([by_a / h**2 - by_v / (2 * h), by_x - 2 * by_a / h**2, by_a / h**2 + by_v / (2 * h)])

    def output_equations(self, x: FloatArray, known: KnownMotion) -> tuple[FloatArray, FloatArray]:
        """Evaluate the output's equations of one sample alone.

        Args:
            x: Unknowns, shape (n_unknowns,).
            known: Known motion, one sample.

        Returns:
            Errors (n_out,), and their derivatives by x (n_out, n_unknowns).
        """
        still = np.tile(x, (3, 1))
        errors, slopes = self.residuals(still, known)[0], self.blocks(still, known)[1, 0]
        return errors[-self.n_out :], slopes[-self.n_out :]

    def _evaluate(self, function: ca.Function, x: FloatArray, known: KnownMotion) -> FloatArray:
        rates = self.rates(x[:, : self.n_arm])
        rows = (x[1:-1], *rates, *(getattr(known, field.name) for field in fields(known)))
        blocks = [
            over_rows(function, *(row[first : first + BLOCK] for row in rows))[0]
            for first in range(0, len(known), BLOCK)
        ]
        return np.concatenate(blocks)


@lru_cache(maxsize=8)
def difference_equations(
    robot: Robot, output: str, step: float, laws: tuple[PlacedLaw, ...] = ()
) -> DifferenceEquations:
    """Build the equations of a robot; they are built once and cached.

    Args:
        robot: The robot.
        output: Name of the controlled output.
        step: Time step h [s].
        laws: Laws of effects that are part of the arm's equations.
    """
    model, n = robot.model, robot.n_arm
    geared = list(robot.gear_rows)
    flexible = [robot.gear_rows[motor] for motor in robot.flexible_motors]
    # forces in units of inertia / h^2, so that all derivatives are of order one
    units = np.diag(np.array(model.arm_inertia(robot.home, model.parameter_values))) / step**2
    x, rates, accelerations = ca.SX.sym("x", n + robot.n_motors), ca.SX.sym("v_x", n), ca.SX.sym("a_x", n)
    rigid = [ca.SX.sym(name, n) for name in ("q_r", "v_r", "a_r")]
    of_gears = [ca.SX.sym(name, len(flexible)) for name in ("gear_rate", "gear_acceleration")]
    q, v, a = rigid[0] + x[:n], rigid[1] + rates, rigid[2] + accelerations
    # motors that follow their gears: no spring torque, and a damper torque only from the known rate of the deflection
    q_m, v_m, a_m = q[flexible], v[flexible] + of_gears[0], a[flexible] + of_gears[1]
    force = arm_residual(
        model, ca.vertcat(q, q_m), ca.vertcat(v, v_m), ca.vertcat(a, a_m), ca.SX.zeros(robot.n_motors),
        arm_forces(robot, laws),
    )  # fmt: skip
    force[flexible] += model.transmission_force(q, v, q_m, v_m, model.parameter_values)[flexible]
    force[geared] -= x[n:] * ca.DM(units[geared])
    value = ToolGeometry.of(robot, laws).output(output, q)
    Z = ca.SX.sym("Z", value.shape[0])
    residual = ca.vertcat(force / ca.DM(units), value - Z)
    none = ca.SX.zeros(residual.shape[0], robot.n_motors)
    slopes = ca.horzcat(
        ca.jacobian(residual, x),
        *[ca.horzcat(ca.jacobian(residual, rate), none) for rate in (rates, accelerations)],
    )
    inputs = [x, rates, accelerations, *rigid, Z, *of_gears]
    return DifferenceEquations(
        n_arm=n,
        n_unknowns=x.shape[0],
        step=step,
        torque_units=units[geared],
        residual=_function("residual", inputs, residual),
        slopes=_function("slopes", inputs, ca.vec(ca.densify(slopes))),
    )


def _function(name: str, inputs: list[ca.SX], output: ca.SX) -> ca.Function:
    """Return a dense function with common subexpressions eliminated."""
    return ca.Function(name, inputs, [ca.densify(output)], {"cse": True})
