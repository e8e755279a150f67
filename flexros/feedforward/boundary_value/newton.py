"""Newton's iteration for all samples at once, with a banded matrix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError, RunError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.feedforward.boundary_value.difference_equations import DifferenceEquations, KnownMotion

MAX_ITERATIONS = 30
"""Iterations after which the solution counts as not found."""

TOLERANCE = 1e-11
"""Largest correction of a converged solution, over the largest unknown [1]."""

FLOOR = 1e-5
"""Corrections below this share of the largest unknown that no longer halve are taken as round-off."""

MOST_BYTES = 2.0e9
"""Largest memory for the matrix [bytes] (chosen)."""


@dataclass(frozen=True)
class BoundarySolution:
    """Solution of a boundary value problem.

    Attributes:
        unknowns: Unknowns with one sample more at either end, shape (n + 2, n_unknowns).
        iterations: Number of Newton iterations.
        corrections: Largest correction of each iteration, over the largest unknown.
    """

    unknowns: FloatArray
    iterations: int
    corrections: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class End:
    """Conditions at an end of the motion, where the robot rests but for what decays towards the outside.

    Attributes:
        rest: Unknowns in equilibrium, shape (n_unknowns,).
        rows: Rows L of L (w - w_rest) = 0 for the two outermost samples, shape (number, 2 n_unknowns).
    """

    rest: FloatArray
    rows: FloatArray

    def errors(self, pair: FloatArray) -> FloatArray:
        """Evaluate the conditions for the unknowns of the two outermost samples, shape (2, n_unknowns)."""
        return np.asarray(self.rows @ (pair - self.rest).ravel())


def solve_boundary_problem(
    equations: DifferenceEquations, known: KnownMotion, start: End, end: End, guess: FloatArray | None = None
) -> BoundarySolution:
    """Solve the equations of all samples, with the robot at rest before the first and bounded after the last.

    Args:
        equations: Equations of one sample.
        known: Known motion, n samples; at rest at both ends.
        start: Conditions for the first two samples.
        end: Conditions for the last two samples.
        guess: Unknowns to begin with, shape (n + 2, n_unknowns); default: from one equilibrium to the other.

    Raises:
        InputError: The matrix would need more memory than allowed.
        RunError: No solution was found.
    """
    n, nz = len(known.position), equations.n_unknowns
    _check_memory(n, nz)
    share = np.linspace(0.0, 1.0, n + 2)[:, None]
    x = start.rest + share * (end.rest - start.rest) if guess is None else guess
    corrections: list[float] = []
    for _ in range(MAX_ITERATIONS):
        system = _linearised(equations, known, start, end, x)
        step = _banded_step(system).reshape(x.shape)
        x = x - step
        corrections.append(float(np.max(np.abs(step)) / max(float(np.max(np.abs(x))), 1e-300)))
        if not np.isfinite(corrections[-1]):
            break
        before = corrections[-2] if len(corrections) > 1 else np.inf
        if corrections[-1] <= TOLERANCE or 0.5 * before < corrections[-1] < FLOOR:
            return BoundarySolution(x, len(corrections), tuple(corrections))
    raise RunError(
        f"the stable inversion found no solution within {len(corrections)} iterations (last correction "
        f"{corrections[-1]:.2g} of the largest deflection): the path passes a singularity, leaves the workspace or is "
        "too fast for the elasticity; move, slow down or smooth the path"
    )


def _check_memory(n: int, nz: int) -> None:
    needed = 8.0 * n * nz * (9 * nz + 1 + 3 * nz)
    if needed > MOST_BYTES:
        raise InputError(
            f"the stable inversion of {n} samples with {nz} unknowns each needs some {needed / 1e9:.2g} GB of memory, "
            f"allowed are {MOST_BYTES / 1e9:g} GB; shorten the motion or raise the sample time"
        )


@dataclass(frozen=True, eq=False)
class _LinearSystem:
    """Linear equations of a Newton step; rows: first two samples, inner samples in order, last two samples."""

    left: FloatArray
    blocks: FloatArray
    right: FloatArray
    residual: FloatArray


def _linearised(
    equations: DifferenceEquations, known: KnownMotion, start: End, end: End, x: FloatArray
) -> _LinearSystem:
    """Linearise all equations about x; the outermost samples meet the output's equations as all others do."""
    first, last = (equations.output_equations(x[k], known.at_rest(k)) for k in (0, -1))
    none = np.zeros_like(first[1])
    residual = (first[0], start.errors(x[:2]), equations.residuals(x, known).ravel(), end.errors(x[-2:]), last[0])
    return _LinearSystem(
        left=np.vstack([np.hstack([first[1], none]), start.rows]),
        blocks=equations.blocks(x, known),
        right=np.vstack([end.rows, np.hstack([none, last[1]])]),
        residual=np.concatenate(residual),
    )


def _banded_step(system: _LinearSystem) -> FloatArray:
    """Solve the linear equations of all samples."""
    from scipy.linalg import LinAlgError, solve_banded  # loads slowly

    left, blocks, right = system.left, system.blocks, system.right
    _, n, nz, _ = blocks.shape
    n_left, size = len(left), (n + 2) * nz
    # columns of sample k start at k nz, rows of inner sample k at n_left + (k - 1) nz
    lower = max(n_left + nz - 1, 2 * nz - 1)
    upper = max(3 * nz - 1 - n_left, 2 * nz - 1)
    band = np.zeros((lower + upper + 1, size))

    def place(values: FloatArray, first_row: IntArray, first_column: IntArray) -> None:
        rows = first_row[:, None, None] + np.arange(values.shape[1])[:, None]
        columns = first_column[:, None, None] + np.arange(values.shape[2])
        band[upper + rows - columns, np.broadcast_to(columns, values.shape)] = values

    place(left[None], np.array([0]), np.array([0]))
    place(right[None], np.array([size - len(right)]), np.array([size - 2 * nz]))
    inner = np.arange(n) * nz
    for neighbour in range(3):
        place(blocks[neighbour], n_left + inner, inner + neighbour * nz)
    try:
        step = solve_banded((lower, upper), band, system.residual, overwrite_ab=True, check_finite=False)
    except (LinAlgError, ValueError):
        return np.full(size, np.nan)
    return np.asarray(step)
