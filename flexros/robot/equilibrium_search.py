"""Newton search for equilibria under gravity, for one robot and for many that differ in parameters."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import casadi as ca
import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.robot.symbolic.model import SymbolicModel

TOLERANCE = 1e-9
"""Largest residual force, relative to the largest stiffness [N or Nm per m or rad]."""
MAX_ITERATIONS = 100

MOST_KEPT = 64
"""Equilibria that a search remembers, as many parameters do not move them [1], chosen."""

LARGEST_STEP = 0.2
"""Largest change of a coordinate in one step [rad or m] (chosen)."""


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """State and holding torque of a robot at rest.

    Attributes:
        state: State x with zero speeds, shape (2 nq,).
        torque: Holding torque of the motors [Nm or N], shape (M,).
    """

    state: FloatArray
    torque: FloatArray


class EquilibriumSearch:
    """Newton search for the equilibrium of gravity and springs, with motors or gears held.

    The balance of an arm coordinate behind a rigid gear is excluded: its motor carries the load.

    Args:
        model: The symbolic model; its free parameters are arguments of each search.
        held: Fixed coordinates: the "motors", with the arm deflected on its springs, or the arm side of the "gears",
            with the motors loading the springs.
    """

    def __init__(self, model: SymbolicModel, held: Literal["motors", "gears"] = "motors") -> None:
        chain, nq = model.chain, model.n_coordinates
        self._name, self._parameter_names = model.specification.name, model.parameter_names
        self._balanced, self._motors = list(chain.spring_rows), list(chain.motor_rows)
        still = self._motors if held == "motors" else chain.gear_rows
        self._free = [row for row in range(nq) if row not in still]
        q, p = ca.SX.sym("q", nq), ca.SX.sym("p", len(model.parameter_names))
        force = model.force(q, np.zeros(nq), np.zeros(model.n_motors), np.zeros(6), p)
        slope = ca.densify(ca.jacobian(force[self._balanced], q)[:, self._free])
        self._force = ca.Function("rest", [q, p], [ca.densify(force), slope])

    def find(self, start: FloatArray, parameters: FloatArray, condition: str = "") -> Equilibrium:
        """Compute the equilibrium for a set of parameters.

        Args:
            start: Initial coordinates q = [q_a, q_m], including the held ones [rad or m], shape (nq,).
            parameters: Values of the model's parameters (SI), shape (n_parameters,).
            condition: Requested condition, for the error message; default: the parameters.

        Returns:
            State and holding torque.

        Raises:
            InputError: The springs do not balance gravity.
        """
        key = start.tobytes(), np.asarray(parameters, dtype=float)[self._moving].tobytes()
        found = self._found.get(key)
        if found is None:
            if len(self._found) >= MOST_KEPT:
                self._found.clear()
            self._found[key] = found = self._searched(start, parameters, condition)
        return Equilibrium(found.state.copy(), found.torque.copy())

    @cached_property
    def _moving(self) -> IntArray:
        """Indices of the parameters on which the equilibrium depends."""
        depending = [np.asarray(self._force.jac_sparsity(row, 1).get_col()) for row in range(self._force.n_out())]
        return np.unique(np.concatenate(depending)).astype(np.int64)

    @cached_property
    def _found(self) -> dict[tuple[bytes, bytes], Equilibrium]:
        """Equilibria found before."""
        return {}

    def _searched(self, start: FloatArray, parameters: FloatArray, condition: str) -> Equilibrium:
        q = start.copy()
        force, slope = self._evaluate(q, parameters)
        for _ in range(MAX_ITERATIONS):
            left = force[self._balanced]
            if not np.any(left) or not np.all(np.isfinite(slope)):
                break
            step = np.linalg.lstsq(slope, -left, rcond=None)[0]
            size = float(np.max(np.abs(step)))
            q[self._free] += step * min(1.0, LARGEST_STEP / max(size, LARGEST_STEP))
            force, slope = self._evaluate(q, parameters)
            if size < 1e-13 * (1.0 + np.max(np.abs(q))):
                break
        self._check(force[self._balanced], slope, condition or self._listing(parameters))
        return Equilibrium(np.concatenate([q, np.zeros_like(q)]), self._holding(force))

    def holding_torque(self, q: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the motor torque [Nm or N], shape (M,), that holds coordinates at rest.

        Args:
            q: Coordinates at rest [rad or m], shape (nq,).
            parameters: Values of the model's parameters (SI), shape (n_parameters,).
        """
        return self._holding(self._evaluate(q, parameters)[0])

    def _holding(self, force: FloatArray) -> FloatArray:
        return 0.0 - force[self._motors]  # not -force, which gives -0.0 for zero

    def _evaluate(self, q: FloatArray, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        force, slope = self._force(q, parameters)
        return force.full().ravel(), slope.full()

    def _check(self, left: FloatArray, slope: FloatArray, condition: str) -> None:
        """Refuse a search that did not converge, also one that ended in NaN."""
        if left.size and not np.max(np.abs(left)) <= TOLERANCE * (1.0 + np.max(np.abs(slope))):
            raise InputError(
                f"robot {self._name} has no equilibrium {condition}: its springs do not balance gravity "
                f"(residual force {np.max(np.abs(left)):.3g} N or Nm); check stiffness, masses and the pose"
            )

    def _listing(self, parameters: FloatArray) -> str:
        pairs = zip(self._parameter_names, parameters, strict=True)
        return f"with {', '.join(f'{name} = {value:g}' for name, value in pairs)}"
