from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError, RunError
from flexros.feedforward.boundary_value import newton
from flexros.feedforward.stable_inversion import bounded_inverse
from flexros.robot import load_robot
from tests.feedforward.cases import CIRCLE, problem_of, tool_trajectory


def test_corrections_fall_quadratically() -> None:
    robot = load_robot("e12_long_tool")
    path = tool_trajectory(robot, CIRCLE, {"type": "ninth_degree", "duration": 0.8}).delayed(0.1)
    found = bounded_inverse(problem_of(robot, path, 1e-3, 1.0)).newton.corrections
    assert found[1] < 2e-3
    assert found[2] < 10 * found[1] ** 2


def test_matrix_beyond_the_memory_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(newton, "MOST_BYTES", 1e6)
    robot = load_robot("e12_long_tool")
    path = tool_trajectory(robot, CIRCLE, {"type": "ninth_degree", "duration": 0.8}).delayed(0.1)
    with pytest.raises(InputError, match=r"samples with 5 unknowns each needs some .* GB"):
        bounded_inverse(problem_of(robot, path, 1e-3, 1.0))


def test_motion_without_solution_ends_in_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(newton, "MAX_ITERATIONS", 1)
    robot = load_robot("e12_long_tool")
    path = tool_trajectory(robot, CIRCLE, {"type": "ninth_degree", "duration": 0.8}).delayed(0.1)
    with pytest.raises(RunError, match="found no solution within 1 iterations"):
        bounded_inverse(problem_of(robot, path, 1e-3, 1.0))


def test_band_matrix_equals_the_dense_one() -> None:
    rng = np.random.default_rng(1)
    n, nz, n_left = 6, 3, 4
    system = newton._LinearSystem(
        left=rng.normal(size=(n_left, 2 * nz)),
        blocks=rng.normal(size=(3, n, nz, nz)),
        right=rng.normal(size=(2 * nz - n_left, 2 * nz)),
        residual=rng.normal(size=(n + 2) * nz),
    )
    dense = np.zeros(((n + 2) * nz, (n + 2) * nz))
    dense[:n_left, : 2 * nz] = system.left
    dense[-(2 * nz - n_left) :, -2 * nz :] = system.right
    for k in range(n):
        dense[n_left + k * nz : n_left + (k + 1) * nz, k * nz : (k + 3) * nz] = np.hstack(system.blocks[:, k])
    np.testing.assert_allclose(dense @ newton._banded_step(system), system.residual, atol=1e-9)
