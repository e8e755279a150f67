from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.prediction.damped_least_squares import Minimum, NormalEquations, StopRule, box_step, minimise

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray

WIDE = np.full(2, np.inf)


def equations_of(
    residual: Callable[[FloatArray], FloatArray], jacobian: Callable[[FloatArray], FloatArray]
) -> Callable[[FloatArray], NormalEquations]:
    def equations(x: FloatArray) -> NormalEquations:
        r, J = residual(x), jacobian(x)
        return NormalEquations(float(r @ r), 2.0 * J.T @ r, 2.0 * J.T @ J)

    return equations


rosenbrock = equations_of(
    lambda x: np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]]),
    lambda x: np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]]),
)


def search(
    start: list[float],
    lower: FloatArray = -WIDE,
    upper: FloatArray = WIDE,
    largest: FloatArray = WIDE,
    stop: StopRule | None = None,
) -> Minimum:
    return minimise(
        rosenbrock, lambda x: rosenbrock(x).cost, np.array(start), lower, upper, largest, stop or StopRule()
    )


def test_minimum_of_rosenbrock_is_found() -> None:
    found = search([-1.2, 1.0])
    np.testing.assert_allclose(found.x, [1.0, 1.0], atol=1e-6)
    assert found.converged


def test_minimum_on_a_bound_is_found() -> None:
    found = search([-1.2, 1.0], upper=np.array([0.5, np.inf]))
    np.testing.assert_allclose(found.x, [0.5, 0.25], atol=1e-6)


def test_no_point_is_evaluated_outside_the_bounds() -> None:
    seen: list[FloatArray] = []

    def watched(x: FloatArray) -> NormalEquations:
        seen.append(x)
        return rosenbrock(x)

    lower, upper = np.array([-1.3, 0.4]), np.array([0.8, 1.5])
    start = np.array([-1.2, 1.0])
    minimise(watched, lambda x: watched(x).cost, start, lower, upper, WIDE, StopRule())
    assert np.all(np.array(seen) >= lower)
    assert np.all(np.array(seen) <= upper)


def test_steps_are_limited() -> None:
    seen = [np.array([-1.2, 1.0])]

    def watched(x: FloatArray) -> NormalEquations:
        assert np.max(np.abs(x - seen[-1])) <= 0.1 + 1e-12
        seen.append(x)
        return rosenbrock(x)

    found = minimise(
        watched, lambda x: rosenbrock(x).cost, seen[0], -WIDE, WIDE, np.full(2, 0.1), StopRule(iterations=1000)
    )
    np.testing.assert_allclose(found.x, [1.0, 1.0], atol=1e-6)


def test_points_at_which_the_model_fails_are_left_out() -> None:
    def failing(x: FloatArray) -> NormalEquations:
        there = rosenbrock(x)
        return there if x[0] < 0.9 else NormalEquations(np.nan, np.full(2, np.nan), np.full((2, 2), np.nan))

    found = minimise(failing, lambda x: failing(x).cost, np.array([-1.2, 1.0]), -WIDE, WIDE, WIDE, StopRule())
    assert np.all(np.isfinite(found.x))
    assert found.cost < rosenbrock(np.array([-1.2, 1.0])).cost


def test_search_that_runs_out_of_steps_has_not_converged() -> None:
    found = search([-1.2, 1.0], stop=StopRule(iterations=3))
    assert found.iterations == 3
    assert not found.converged


def test_parameter_without_influence_stays() -> None:
    def flat(x: FloatArray) -> NormalEquations:
        return NormalEquations(x[0] ** 2, np.array([2 * x[0], 0.0]), np.diag([2.0, 0.0]))

    found = minimise(flat, lambda x: flat(x).cost, np.array([3.0, 7.0]), -WIDE, WIDE, WIDE, StopRule())
    np.testing.assert_allclose(found.x, [0.0, 7.0], atol=1e-6)


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_box_step_solves_the_rest_again_when_one_parameter_hits_its_side(damping: float) -> None:
    H, g = np.array([[2.0, 1.0], [1.0, 3.0]]), np.array([-4.0, 1.0])
    step = box_step(NormalEquations(0.0, g, H), damping, np.full(2, -np.inf), np.array([0.5, np.inf]))
    assert step[0] == 0.5
    assert step[1] == pytest.approx((-g[1] - H[1, 0] * 0.5) / (H[1, 1] * (1.0 + damping)))


@pytest.mark.parametrize(("cost", "slope"), [(np.nan, np.nan), (np.inf, 0.0), (1.0, np.nan)])
def test_search_whose_model_fails_at_the_start_has_not_converged(cost: float, slope: float) -> None:
    def failing(x: FloatArray) -> NormalEquations:
        return NormalEquations(cost, np.full(2, slope), np.eye(2))

    found = minimise(failing, lambda x: cost, np.array([3.0, 7.0]), -WIDE, WIDE, WIDE, StopRule())
    assert not found.converged
    assert (found.iterations, found.evaluations) == (0, 1)
    np.testing.assert_array_equal(found.x, [3.0, 7.0])
