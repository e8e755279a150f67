"""Exact time derivatives of the joint motion from those of the tool motion."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.over_rows import over_rows
from flexros.errors import InputError
from flexros.trajectory.path import MAX_DERIVATIVES

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.trajectory.trajectory import Trajectory

CONTINUATION_STEP = 0.01
"""Initial time step of the continuation of the joint position along the trajectory [s]; halved where necessary."""

SINGULAR = 1e-6
"""Smallest singular value of the Jacobian, relative to its largest, with which derivatives are computed (chosen)."""

_LARGEST_NEWTON_STEP = 0.3
"""Newton steps are shortened to this size [rad or m], so that the iteration stays in its configuration (chosen)."""


@dataclass(frozen=True, eq=False)
class OutputDerivatives:
    """Total time derivatives of Z = Gamma(q(t)), built once per output function.

    Args:
        gamma: Output function q -> Z.
        size: Number of joints.
        n_out: Number of tool coordinates.
        value_and_slope: q -> (Z, dGamma/dq).
        total: k-th entry: (q, dq/dt, ..., k-th derivative) -> k-th derivative of Z.
    """

    gamma: ca.Function
    size: int
    n_out: int
    value_and_slope: ca.Function
    total: tuple[ca.Function, ...]

    @classmethod
    def of(cls, gamma: ca.Function) -> OutputDerivatives:
        """Differentiate an output function up to four times along a motion.

        Args:
            gamma: casadi.Function with one input q (n_joints,) and one output Z (n_out,).

        Returns:
            The derivatives as CasADi functions, by repeated directional differentiation (exact).

        Raises:
            InputError: The function has other inputs or outputs.
        """
        if gamma.n_in() != 1 or gamma.n_out() != 1 or gamma.size2_in(0) != 1 or gamma.size2_out(0) != 1:
            raise InputError(
                f"the output function {gamma.name()} has {gamma.n_in()} inputs and {gamma.n_out()} outputs, allowed is "
                "one vector of joints and one vector of tool coordinates; substitute the parameters first"
            )
        size = gamma.size1_in(0)
        motion = [ca.SX.sym(f"q{k}", size) for k in range(MAX_DERIVATIVES + 1)]
        value = ca.densify(gamma.expand()(motion[0]))
        slope = ca.densify(ca.jacobian(value, motion[0]))
        expression, total = value, [ca.Function("z0", motion[:1], [value])]
        for k in range(MAX_DERIVATIVES):
            parts = [ca.jtimes(expression, motion[i], motion[i + 1]) for i in range(k + 1)]
            expression = ca.cse(sum(parts, start=ca.SX.zeros(value.shape)))
            total.append(ca.Function(f"z{k + 1}", motion[: k + 2], [ca.densify(expression)]))
        return cls(gamma, size, gamma.size1_out(0), ca.Function("slope", motion[:1], [value, slope]), tuple(total))

    def along(self, motion: FloatArray) -> FloatArray:
        """Return Z and its time derivatives of a joint motion.

        Args:
            motion: q and its time derivatives, shape (derivatives + 1, n, n_joints).

        Returns:
            Shape (derivatives + 1, n, n_out).
        """
        return np.array([self.highest(motion[: k + 1]) for k in range(len(motion))])

    def highest(self, motion: FloatArray) -> FloatArray:
        """Return the highest time derivative of Z of a joint motion, shape (n, n_out)."""
        return over_rows(self.total[len(motion) - 1], *motion)[0]

    def value_slope(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return Z and the Jacobian at n joint positions, shapes (n, n_out) and (n, n_out, n_joints)."""
        value, slope = over_rows(self.value_and_slope, q)
        return value, slope.reshape(len(q), self.n_out, self.size)


def joint_derivatives(
    trajectory: Trajectory,
    gamma: ca.Function | OutputDerivatives,
    near: FloatArray,
    t: FloatArray,
    derivatives: int = MAX_DERIVATIVES,
) -> FloatArray:
    """Return the joint motion of a trajectory with its exact time derivatives, for Gamma(q(t)) = Z(t).

    The position is solved by Newton's method, continued from the start of the trajectory so that the configuration is
    kept. The derivatives follow from the constraint differentiated k times (as for equation 5.5 of Moberg 2007),

        J(q) q^(k) = Z^(k) - (k-th derivative of Gamma(q(t)) with q^(k) = 0).

    Args:
        trajectory: Tool trajectory; the motion of a joint trajectory is returned unchanged.
        gamma: Output function q -> Z of as many joints as tool coordinates, or its derivatives.
        near: Joint position near that of the trajectory's start [rad or m], shape (n_joints,).
        t: Times [s], any order, shape (n,).
        derivatives: Highest derivative, 0 to 4.

    Returns:
        q, dq/dt, ..., shape (derivatives + 1, n, n_joints).

    Raises:
        InputError: Not as many joints as coordinates, out of reach or singular; the message names the point.
    """
    t = np.atleast_1d(np.asarray(t, dtype=float))
    target = trajectory.evaluate(t, derivatives)
    if trajectory.joints or t.size == 0:
        return target
    output = gamma if isinstance(gamma, OutputDerivatives) else OutputDerivatives.of(gamma)
    if output.n_out != output.size or output.n_out != trajectory.n_out or np.size(near) != output.size:
        raise InputError(
            f"the trajectory has {trajectory.n_out} coordinates, the output function {output.n_out} for {output.size} "
            f"joints, and the start {np.size(near)} joints, allowed are equal numbers; choose an output with one "
            "coordinate per joint"
        )
    q = _refined(trajectory, output, _continued(trajectory, output, near, t), t, target[0])
    motion = np.zeros((derivatives + 1, *q.shape))
    motion[0] = q
    _, slope = output.value_slope(q)
    _check_regular(trajectory, slope, t)
    for k in range(1, derivatives + 1):
        rest = target[k] - output.highest(motion[: k + 1])
        motion[k] = np.linalg.solve(slope, rest[:, :, None])[:, :, 0]
    return motion


def _continued(trajectory: Trajectory, output: OutputDerivatives, near: FloatArray, t: FloatArray) -> FloatArray:
    """Continue the joint position from the start in coarse steps, interpolate at the times, shape (n, n_joints)."""
    end = min(max(float(np.max(t)), 0.0), trajectory.duration)
    grid, positions, speeds = _from_start(trajectory, output, tuple(map(float, near)), end)
    if grid.size == 1:
        return np.tile(positions[0], (t.size, 1))
    return cubic_hermite(grid, positions, speeds, np.clip(t, 0.0, end))


@lru_cache(maxsize=4)
def _from_start(
    trajectory: Trajectory, output: OutputDerivatives, near: tuple[float, ...], end: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return coarse times up to the end with joint positions and speeds; asked for many times along one trajectory."""
    grid = np.linspace(0.0, end, max(2, int(np.ceil(end / CONTINUATION_STEP)) + 1)) if end > 0.0 else np.zeros(1)
    target = trajectory.evaluate(grid, 1)
    q = _newton(output, target[0, 0], np.array(near, dtype=float))
    if q is None:
        raise _out_of_reach(trajectory, 0.0)
    positions, speeds = [q], [_speed(trajectory, output, q, target[1, 0], 0.0)]
    for k in range(1, grid.size):
        q = _advance(trajectory, output, grid[k - 1 : k + 1], positions[-1], target[0, k])
        positions.append(q)
        speeds.append(_speed(trajectory, output, q, target[1, k], float(grid[k])))
    return grid, np.array(positions), np.array(speeds)


def cubic_hermite(grid: FloatArray, values: FloatArray, slopes: FloatArray, t: FloatArray) -> FloatArray:
    """Interpolate by cubic polynomials with given values and slopes at the ends of each interval.

    The result equals that of `scipy.interpolate.CubicHermiteSpline`, which loads slowly, bit for bit.

    Args:
        grid: Increasing times, at least two, shape (m,).
        values: Values at these times, shape (m, n_joints).
        slopes: Time derivatives at these times, shape (m, n_joints).
        t: Times within the grid, any order, shape (n,).

    Returns:
        Shape (n, n_joints).
    """
    width = np.diff(grid)[:, None]
    secant = np.diff(values, axis=0) / width
    excess = (slopes[:-1] + slopes[1:] - 2 * secant) / width
    interval = np.clip(np.searchsorted(grid, t, side="right") - 1, 0, grid.size - 2)
    s = (t - grid[interval])[:, None]
    quadratic, cubic = (secant - slopes[:-1]) / width - excess, excess / width
    result: FloatArray = values[interval] + slopes[interval] * s
    result = result + quadratic[interval] * (s * s)
    return result + cubic[interval] * (s * s * s)


def _advance(
    trajectory: Trajectory, output: OutputDerivatives, times: FloatArray, q: FloatArray, target: FloatArray
) -> FloatArray:
    """Continue the joint position from one time to the next, in halved steps where Newton's method fails."""
    begin, end = float(times[0]), float(times[1])
    goals = [(end, target)]
    while goals:
        time, goal = goals[-1]
        solution = _newton(output, goal, q)
        if solution is not None and float(np.max(np.abs(solution - q))) < _LARGEST_NEWTON_STEP:
            q, begin = solution, time
            goals.pop()
        elif time - begin < 1e-7 or len(goals) > 40:
            raise _out_of_reach(trajectory, time)
        else:
            middle = 0.5 * (begin + time)
            goals.append((middle, trajectory.evaluate(np.array([middle]), 0)[0, 0]))
    return q


def _newton(output: OutputDerivatives, target: FloatArray, q: FloatArray) -> FloatArray | None:
    """Solve Gamma(q) = target from an initial value; None if it does not converge."""
    for _ in range(60):
        value, slope = output.value_slope(q[None])
        error = target - value[0]
        try:
            step = np.linalg.solve(slope[0], error)
        except np.linalg.LinAlgError:
            return None
        size = float(np.max(np.abs(step)))
        q = q + step * min(1.0, _LARGEST_NEWTON_STEP / max(size, 1e-300))
        if size < 1e-9:
            return q
    return None


def _refined(
    trajectory: Trajectory, output: OutputDerivatives, q: FloatArray, t: FloatArray, target: FloatArray
) -> FloatArray:
    """Improve all joint positions at once by Newton's method, down to rounding."""
    limit = 1e-13 * (1.0 + np.max(np.abs(target), axis=1))
    error = np.zeros_like(target)
    for _ in range(12):
        value, slope = output.value_slope(q)
        error = target - value
        if np.all(np.max(np.abs(error), axis=1) <= limit):
            return q
        _check_regular(trajectory, slope, t)
        q = q + np.linalg.solve(slope, error[:, :, None])[:, :, 0]
    worst = int(np.argmax(np.max(np.abs(error), axis=1) / limit))
    if np.max(np.abs(error[worst])) > 1e3 * limit[worst]:
        raise _out_of_reach(trajectory, float(t[worst]))
    return q


def _speed(
    trajectory: Trajectory, output: OutputDerivatives, q: FloatArray, speed: FloatArray, time: float
) -> FloatArray:
    _, slope = output.value_slope(q[None, :])
    _check_regular(trajectory, slope, np.array([time]))
    result: FloatArray = np.linalg.solve(slope[0], speed)
    return result


def _check_regular(trajectory: Trajectory, slope: FloatArray, t: FloatArray) -> None:
    sizes = np.linalg.svd(slope, compute_uv=False)
    ratio = sizes[:, -1] / np.maximum(sizes[:, 0], 1e-300)
    worst = int(np.argmin(ratio))
    if not ratio[worst] > SINGULAR:
        raise InputError(
            f"the trajectory passes a singularity of the robot at {trajectory.place(float(t[worst]))}, allowed are "
            "paths on which the joints follow from the tool; move the path away from there"
        )


def _out_of_reach(trajectory: Trajectory, time: float) -> InputError:
    return InputError(
        f"the trajectory is out of reach or singular at {trajectory.place(time)}: no joint position reaches it; "
        "move the start, turn the path or make it smaller"
    )
