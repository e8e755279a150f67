from __future__ import annotations

import ctypes

import numpy as np
import pytest

from flexros.compile import ModuleBuilder
from flexros.compile.linear_solver import add_lu_solver
from flexros.errors import InputError

SIZES = [1, 2, 3, 5, 7, 8, 9, 16, 24, 41, 122]


class Solver:
    """The routines of one size, called from Python."""

    def __init__(self, n: int, *, row_major: bool = False) -> None:
        builder = ModuleBuilder()
        routines = add_lu_solver(builder, n, row_major=row_major)
        self.code = builder.build()
        self.order = "C" if row_major else "F"
        self.work = np.zeros(routines.work_size)
        pointer, whole = ctypes.c_void_p, ctypes.c_int64
        self._factor = ctypes.CFUNCTYPE(whole, pointer, pointer)(self.code.address(routines.factor))
        self._solve = ctypes.CFUNCTYPE(None, pointer, pointer, whole)(self.code.address(routines.solve))
        self._both = ctypes.CFUNCTYPE(whole, pointer, pointer)(self.code.address(routines.factor_solve))

    def factor(self, matrix: np.ndarray) -> int:
        stored = np.array(matrix, order=self.order)
        return self._factor(stored.ctypes.data, self.work.ctypes.data)

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        solution = np.array(rhs, order="F")
        self._solve(self.work.ctypes.data, solution.ctypes.data, rhs.shape[1])
        return solution

    def factor_solve(self, matrix: np.ndarray, rhs: np.ndarray) -> tuple[int, np.ndarray]:
        stored, solution = np.array(matrix, order=self.order), np.array(rhs)
        return self._both(stored.ctypes.data, solution.ctypes.data), solution


def residual(matrix: np.ndarray, solution: np.ndarray, rhs: np.ndarray) -> float:
    """Normwise backward error in units of rounding."""
    scale = np.abs(matrix).sum(1).max() * np.abs(solution).max()
    return float(np.abs(matrix @ solution - rhs).max() / scale / np.finfo(float).eps)


@pytest.mark.slow
@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("row_major", [False, True])
def test_solution_is_backward_stable(n: int, row_major: bool) -> None:
    rng = np.random.default_rng(n)
    solver = Solver(n, row_major=row_major)
    for _ in range(5):
        matrix, rhs = rng.normal(size=(n, n)), rng.normal(size=n)
        status, solution = solver.factor_solve(matrix, rhs)
        assert status == 0
        assert residual(matrix, solution, rhs) < 2 * n + 10


@pytest.mark.parametrize("n", SIZES)
def test_factors_serve_several_right_hand_sides(n: int) -> None:
    rng = np.random.default_rng(n)
    matrix, rhs = rng.normal(size=(n, n)), rng.normal(size=(n, 3))
    solver = Solver(n)
    assert solver.factor(matrix) == 0
    assert residual(matrix, solver.solve(rhs), rhs) < 2 * n + 10


@pytest.mark.parametrize("n", [3, 24])
def test_a_zero_on_the_diagonal_is_exchanged(n: int) -> None:
    matrix = np.roll(np.eye(n), 1, axis=0)
    status, solution = Solver(n).factor_solve(matrix, np.arange(n, dtype=float))
    assert status == 0
    np.testing.assert_array_equal(matrix @ solution, np.arange(n))


@pytest.mark.parametrize("n", [4, 20])
def test_pivoting_keeps_a_badly_scaled_system_accurate(n: int) -> None:
    rng = np.random.default_rng(3)
    matrix = rng.normal(size=(n, n))
    matrix[0, 0] = 1e-18
    rhs = rng.normal(size=n)
    _, solution = Solver(n).factor_solve(matrix, rhs)
    np.testing.assert_allclose(solution, np.linalg.solve(matrix, rhs), rtol=1e-10)


@pytest.mark.parametrize("n", [3, 24])
@pytest.mark.parametrize("bad", [0.0, np.nan, np.inf])
def test_status_tells_the_pivot_that_fails(n: int, bad: float) -> None:
    matrix = np.eye(n)
    matrix[2, 2] = bad
    solver = Solver(n)
    assert solver.factor_solve(matrix, np.ones(n))[0] == 3
    assert solver.factor(matrix) == 3


def test_routines_are_added_once() -> None:
    builder = ModuleBuilder()
    assert add_lu_solver(builder, 5) == add_lu_solver(builder, 5)


def test_size_must_be_positive() -> None:
    with pytest.raises(InputError, match="at least 1 unknown, n = 0"):
        add_lu_solver(ModuleBuilder(), 0)
