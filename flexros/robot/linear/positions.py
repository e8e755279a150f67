"""A robot linearised at the positions of an experiment, with slopes in its unknowns (Paper A, section 3)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.errors import InputError
from flexros.robot.equilibrium_search import EquilibriumSearch
from flexros.robot.linear.parameter_terms import MATRIX, ParameterTerms, parameter_terms

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from flexros.arrays import FloatArray, IntArray
    from flexros.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class LinearisedPositions:
    """Linear models M dq'' + D dq' + K dq = B du of Q positions at rest, and their slopes in P parameters.

    Springs, dampers, motor inertias and motor friction are rank-one terms: they add
    theta_p factor_p (jw)^power_p b_p b_p^T to A(jw) = -w^2 M + jw D + K. Any other parameter (mass, centre of mass,
    inertia, length) changes the matrices by its slopes, to first order at `values` (chosen: the outer loop of a fit
    linearises again). Equilibria are those of `values`.

    Attributes:
        robot_name: Name of the robot.
        names: Names of the parameters, length P.
        values: Their values at the linearisation (SI), shape (P,).
        motor_positions: Held motor positions [rad or m], shape (Q, M).
        coordinates: Coordinates q = [q_a, q_m] at rest under gravity [rad or m], shape (Q, n).
        mass: M at `values`, shape (Q, n, n).
        damping: D, shape (Q, n, n).
        stiffness: K, gravity load included, shape (Q, n, n).
        motor_rows: Row of each motor position among the coordinates, selected by B and B^T, shape (M,).
        vectors: b_p, zero for parameters that are not rank-one terms, shape (P, n).
        powers: 0 stiffness, 1 damping, 2 inertia, MATRIX (-1) for parameters with slopes, shape (P,).
        factors: Slope of the law of a nonlinear spring at its load (its parameter is a factor), else 1, shape (Q, P).
        mass_slopes: dM/dtheta of the G parameters with slopes, in their order, shape (Q, G, n, n).
        damping_slopes: dD/dtheta, shape (Q, G, n, n).
        stiffness_slopes: dK/dtheta at the fixed equilibrium, shape (Q, G, n, n).
    """

    robot_name: str
    names: tuple[str, ...]
    values: FloatArray
    motor_positions: FloatArray
    coordinates: FloatArray
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    motor_rows: IntArray
    vectors: FloatArray
    powers: IntArray
    factors: FloatArray
    mass_slopes: FloatArray
    damping_slopes: FloatArray
    stiffness_slopes: FloatArray

    @property
    def sloped(self) -> IntArray:
        """Indices of the parameters that are not rank-one terms, shape (G,)."""
        return np.flatnonzero(self.powers == MATRIX)

    def matrices(self, theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return M, D and K, each of shape (Q, n, n), for other parameter values (SI), at the same equilibria."""
        change = theta - self.values
        sums = [self._rank_one_sum(power, change) for power in (2, 1, 0)]
        given = (self.mass, self.damping, self.stiffness)
        if self.sloped.size:
            slopes = (self.mass_slopes, self.damping_slopes, self.stiffness_slopes)
            sums = [
                part + np.tensordot(change[self.sloped], slope, (0, 1))
                for part, slope in zip(sums, slopes, strict=True)
            ]
        mass, damping, stiffness = (matrix + part for matrix, part in zip(given, sums, strict=True))
        return mass, damping, stiffness

    def _rank_one_sum(self, power: int, change: FloatArray) -> FloatArray:
        """Return the sum of change_p factor_p b_p b_p^T over the parameters of one power, shape (Q, n, n)."""
        chosen = self.powers == power
        vectors = self.vectors[chosen]
        total: FloatArray = np.matmul(vectors.T, (self.factors * change)[:, chosen, None] * vectors)
        return total


def linearise_positions(
    robot: Robot, names: Sequence[str], motor_positions: ArrayLike, values: ArrayLike | None = None
) -> LinearisedPositions:
    """Linearise a robot at equilibria with its motors held.

    Args:
        robot: The robot.
        names: Names of the unknown parameters, length P.
        motor_positions: Motor positions [rad or m], shape (Q, M).
        values: Values of the parameters (SI), shape (P,); default: those of the robot.

    Returns:
        The linear models and their slopes.

    Raises:
        InputError: Unknown or repeated names, values that are not finite, invalid motor positions, or no equilibrium.
    """
    functions = _functions(robot, tuple(names))
    checked = _checked_values(robot, functions, values)
    motors = _checked_positions(robot, motor_positions)
    rests = np.array([_rest(robot, functions, position, checked) for position in motors])
    results = [[part.full() for part in functions.evaluate(q, checked)] for q in rests]
    mass, damping, stiffness, factors, *slopes = (np.array(part) for part in zip(*results, strict=True))
    mass_slopes, damping_slopes, stiffness_slopes = (_as_matrices(slope, robot.n_coordinates) for slope in slopes)
    return LinearisedPositions(
        robot_name=robot.name,
        names=functions.names,
        values=checked,
        motor_positions=motors,
        coordinates=rests,
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        motor_rows=np.array(robot.motor_rows, dtype=np.int64),
        vectors=functions.terms.vectors,
        powers=functions.terms.powers,
        factors=factors[:, :, 0],
        mass_slopes=mass_slopes,
        damping_slopes=damping_slopes,
        stiffness_slopes=stiffness_slopes,
    )


@dataclass(frozen=True, eq=False)
class _Functions:
    """Functions that are built once per robot and set of names."""

    names: tuple[str, ...]
    nominal: FloatArray
    terms: ParameterTerms
    search: EquilibriumSearch
    evaluate: ca.Function


@lru_cache(maxsize=8)
def _functions(robot: Robot, names: tuple[str, ...]) -> _Functions:
    model = robot.symbolic(names)
    terms = parameter_terms(robot, names)
    n = robot.n_coordinates
    q, v, p = ca.SX.sym("q", n), ca.SX.sym("v", n), ca.SX.sym("p", len(names))
    force = model.force(q, v, np.zeros(robot.n_motors), np.zeros(6), p)
    damping, stiffness = (ca.substitute(-ca.jacobian(force, by), v, ca.SX.zeros(n)) for by in (v, q))
    matrices = [model.mass_matrix(q, p), damping, (stiffness + stiffness.T) / 2]  # symmetric up to round-off
    sloped = np.flatnonzero(terms.powers == MATRIX).tolist()
    slopes = [ca.jacobian(ca.vec(matrix), p)[:, sloped] for matrix in matrices]
    results = [ca.densify(result) for result in (*matrices, terms.factors(q), *slopes)]
    evaluate = ca.Function("linearised", [q, p], results, {"cse": True})
    return _Functions(names, model.parameter_values, terms, EquilibriumSearch(model, "motors"), evaluate)


def _as_matrices(columns: FloatArray, n: int) -> FloatArray:
    """Reshape columns of column-major matrices, shape (Q, n n, G), to matrices, shape (Q, G, n, n)."""
    n_positions, _, n_sloped = columns.shape
    matrices: FloatArray = columns.reshape(n_positions, n, n, n_sloped).transpose(0, 3, 2, 1)
    return matrices


def _rest(robot: Robot, functions: _Functions, motors: FloatArray, values: FloatArray) -> FloatArray:
    """Return the coordinates at rest with the motors held; the search starts at home with unloaded gears."""
    chain = robot.chain
    q_a = robot.home.copy()
    q_a[list(chain.gear_rows)] = motors
    flexible = [chain.gear_rows[number] for number in chain.flexible_motors]
    pairs = ", ".join(f"{name} = {value:g}" for name, value in zip(functions.names, values, strict=True))
    condition = f"at motor positions {np.round(motors, 6).tolist()} with {pairs}"
    rest = functions.search.find(np.concatenate([q_a, q_a[flexible]]), values, condition)
    return rest.state[: robot.n_coordinates]


def _checked_values(robot: Robot, functions: _Functions, values: ArrayLike | None) -> FloatArray:
    checked = functions.nominal if values is None else np.asarray(values, dtype=float)
    if checked.shape != functions.nominal.shape:
        raise InputError(
            f"{checked.size} values were given for {len(functions.names)} unknown parameters of robot {robot.name}; "
            "give one value for each"
        )
    if not np.all(np.isfinite(checked)):
        wrong = [name for name, value in zip(functions.names, checked, strict=True) if not np.isfinite(value)]
        raise InputError(f"the value of {', '.join(wrong)} is not a finite number; give one")
    return checked


def _checked_positions(robot: Robot, motor_positions: ArrayLike) -> FloatArray:
    motors = np.asarray(motor_positions, dtype=float)
    if motors.ndim != 2 or motors.shape[1] != robot.n_motors or not len(motors) or not np.all(np.isfinite(motors)):
        raise InputError(
            f"motor positions have shape {motors.shape}, but robot {robot.name} needs finite numbers, one row per "
            f"position and one column for each of {', '.join(robot.joint_names)}; correct them"
        )
    return motors
