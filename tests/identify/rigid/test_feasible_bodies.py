"""Feasible bodies nearest to base parameters that no robot has."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

from flexros.identify.rigid.feasible_bodies import feasible_parameters

BODY = list(range(10))
GUESS = np.array([0.04, 0.05, 0.03, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 2.0, 0.0])
REAL = np.array([0.081, 0.09, 0.021, 0.002, -0.001, 0.003, 0.02, -0.04, 0.3, 3.0, 0.25])

CLEAR = 1e3 * np.eye(11)
"""Equations that tell each parameter."""


def pseudo(body: np.ndarray) -> np.ndarray:
    """Return the pseudo-inertia of a body."""
    xx, yy, zz, xy, xz, yz = body[:6]
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    return np.block([[second, body[6:9, None]], [body[None, 6:9], body[None, 9:10]]])


def test_a_feasible_solution_is_found() -> None:
    found = feasible_parameters(GUESS, {"body_1": BODY}, [10], CLEAR @ REAL, CLEAR)
    assert found is not None
    np.testing.assert_allclose(found, REAL, atol=1e-4)


def test_what_equations_do_not_tell_makes_no_body_flat() -> None:
    told = np.array([1, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1.0])
    found = feasible_parameters(GUESS, {"body_1": BODY}, [10], CLEAR @ (told * REAL), CLEAR * told)
    assert found is not None
    np.testing.assert_allclose(found[told > 0], REAL[told > 0], atol=1e-3)
    assert scipy.linalg.eigh(pseudo(found), pseudo(REAL), eigvals_only=True).min() > 0.1


def test_an_infeasible_one_is_approached_by_a_body_that_can_be() -> None:
    wanted = REAL.copy()
    wanted[2], wanted[10] = -0.05, -1.0
    found = feasible_parameters(GUESS, {"body_1": BODY}, [10], CLEAR @ wanted, CLEAR)
    assert found is not None
    assert np.linalg.eigvalsh(pseudo(found)).min() > 0
    assert found[10] == pytest.approx(0.0, abs=1e-3)
    assert np.linalg.norm(found - wanted) < np.linalg.norm(GUESS - wanted)


def test_a_body_without_inertia_is_no_place_to_begin() -> None:
    point = GUESS.copy()
    point[:6] = 0.0
    assert feasible_parameters(point, {"body_1": BODY}, [], REAL, np.eye(11)) is None
