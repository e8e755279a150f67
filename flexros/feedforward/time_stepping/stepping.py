"""Contract of time stepping: state, result and tolerance; state in, state out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.feedforward.time_stepping.dae_equations import DaeEquations

MAX_ITERATIONS = 30
"""Iterations after which a step counts as failed."""

CHORD_ITERATIONS = 4
"""Number of iterations with the matrix of an earlier step; after them it is renewed at every iteration."""

STALE_ITERATIONS = 3
"""After a step with more iterations than this, the next step renews the matrix."""

FLOOR_FACTOR = 100.0
"""Corrections below this many tolerances that no longer halve with a fresh matrix are taken as round-off too."""

ROUND_OFF = 2.0**-52
"""Relative spacing of the floating-point numbers."""


@dataclass(frozen=True)
class StepLayout:
    """Offsets in the flat state vector of a stepper.

    The state holds z and its first three backward differences, v and its first difference, the factors of the Newton
    matrix, and the flag that they are to be renewed. Newton's iterates depend on the factors: with them in the state,
    the result does not depend on how the samples are divided into chunks.

    Attributes:
        n_unknowns: Number of unknowns z.
        n_coordinates: Number of rates v.
        n_factors: Length of the factorised matrix with its pivots.
    """

    n_unknowns: int
    n_coordinates: int
    n_factors: int

    @property
    def rates(self) -> int:
        """Offset of the rates."""
        return 4 * self.n_unknowns

    @property
    def factors(self) -> int:
        """Offset of the factors."""
        return self.rates + 2 * self.n_coordinates

    @property
    def stale(self) -> int:
        """Offset of the flag that the factors are to be renewed."""
        return self.factors + self.n_factors

    @property
    def size(self) -> int:
        """Length of the state vector."""
        return self.stale + 1

    def at_rest(self, z: FloatArray) -> FloatArray:
        """Return the state of a robot that has always been at rest.

        Args:
            z: Unknowns in equilibrium, shape (n_unknowns,).

        Returns:
            State, shape (size,).
        """
        state = np.zeros(self.size)
        state[: self.n_unknowns] = z
        state[self.stale] = 1.0
        return state


@dataclass(frozen=True)
class SteppingResult:
    """Solution over n samples.

    Attributes:
        state: State after the last solved sample, shape (StepLayout.size,).
        z: Solutions, shape (n, n_unknowns).
        motors: Motor torque [Nm or N], load [Nm or N], momentum [Nms or Ns], encoder position [rad or m] and its
            rate at the samples, shape (n, 5, M); see `flexros.feedforward.motion.Motion`.
        iterations: Newton iterations of each sample, shape (n,).
        failed: Index of the first sample at which Newton's iteration did not converge; n if all converged. All rows
            from it on are invalid.
    """

    state: FloatArray
    z: FloatArray
    motors: FloatArray
    iterations: IntArray
    failed: int


class Stepper(Protocol):
    """Time stepping of the DAE for a given robot, order and sample time."""

    layout: StepLayout

    def advance(self, state: FloatArray, outputs: FloatArray, tolerance: FloatArray) -> SteppingResult:
        """Solve successive samples.

        Args:
            state: State before the first of them, shape (layout.size,); not changed.
            outputs: Desired outputs [m or rad], shape (n, n_out).
            tolerance: Inverse size of the corrections that end Newton's iteration, see `newton_tolerance`.

        Returns:
            Solutions and the state after the last of them.
        """


def newton_tolerance(equations: DaeEquations, gamma: float, initial: FloatArray) -> FloatArray:
    """Compute the size of a correction that round-off alone causes, per unknown.

    A round-off error of the output Gamma(q_a) - Z changes the unknowns by the inverse Newton matrix times the error. A
    solution cannot be more accurate than that; Newton's iteration continues until it is as accurate.

    Args:
        equations: One step of the DAE.
        gamma: Leading coefficient of the difference formula over the step size [1/s].
        initial: Unknowns z at the start, shape (n_unknowns,).

    Returns:
        Inverse of the largest correction that ends the iteration, shape (n_unknowns,).
    """
    rest, zero = np.zeros(equations.n_coordinates), np.zeros(equations.n_unknowns)
    matrix = np.array(equations.newton_matrix(zero, initial, rest, rest, gamma, 1.0 / gamma**2))
    output = np.array(equations.residual(zero, initial, rest, rest, gamma, 0.0, np.zeros(equations.n_motors))).ravel()
    noise = ROUND_OFF * np.maximum(1.0, np.abs(output))
    noise[: equations.n_arm] = 0.0
    moved = np.abs(np.linalg.inv(matrix)) @ noise
    return np.asarray(1.0 / (4.0 * moved + ROUND_OFF * (1.0 + np.abs(initial))))
