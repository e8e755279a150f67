"""H-infinity synthesis: the bound holds, and rounding errors do not decide the controller."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.design.continuous import ContinuousSystem
from flexros.control.design.h_infinity import ABOVE_LEAST, h_infinity
from flexros.control.design.methods.base import DesignProblem
from flexros.control.design.methods.mu_synthesis import MuSynthesis, closed_response
from flexros.errors import InputError
from flexros.robot import load_robot

pytest.importorskip("slycot")

FREQUENCY = np.geomspace(1e-3, 1e3, 400)


@pytest.fixture(scope="module")
def lightly_damped() -> ContinuousSystem:
    return MuSynthesis(noise=2e-4).generalised_plant(DesignProblem.of(load_robot("four_mass")))


def closed(plant: ContinuousSystem, controller: ContinuousSystem) -> np.ndarray:
    return np.linalg.svd(closed_response(plant, controller, FREQUENCY), compute_uv=False)[:, 0]


def test_least_norm_of_an_integrator_is_that_of_theory() -> None:
    # x' = w1 + u, z = (x, u), y = x + w2 (K. Glover and D. McFarlane 1989: sqrt(1 + X Y) with both Riccati solutions 1)
    plant = ContinuousSystem(
        np.array([[-1e-6]]),
        np.array([[1.0, 0.0, 1.0]]),
        np.array([[1.0], [0.0], [1.0]]),
        np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
    )
    _, bound = h_infinity(plant, 1, 1, "test")
    assert bound / ABOVE_LEAST == pytest.approx(np.sqrt(2.0), rel=1e-3)


def test_closed_loop_keeps_the_bound(lightly_damped: ContinuousSystem) -> None:
    controller, bound = h_infinity(lightly_damped, 1, 1, "test")
    assert 0.8 * bound < closed(lightly_damped, controller).max() < bound


def test_plant_that_is_a_rounding_error_off_has_the_same_loop(lightly_damped: ContinuousSystem) -> None:
    first = closed(lightly_damped, h_infinity(lightly_damped, 1, 1, "test")[0])
    rng = np.random.default_rng(1)
    A = lightly_damped.A * (1 + 1e-14 * rng.standard_normal(lightly_damped.A.shape))
    off = ContinuousSystem(A, lightly_damped.B, lightly_damped.C, lightly_damped.D)
    np.testing.assert_allclose(closed(lightly_damped, h_infinity(off, 1, 1, "test")[0]), first, rtol=1e-3)


def test_plant_that_no_control_reaches_is_refused() -> None:
    plant = ContinuousSystem(
        np.array([[1.0]]),
        np.array([[1.0, 0.0, 0.0]]),
        np.array([[1.0], [0.0], [1.0]]),
        np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
    )
    with pytest.raises(InputError, match="no controller"):
        h_infinity(plant, 1, 1, "test")
