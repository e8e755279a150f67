from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from flexros.errors import InputError
from flexros.trajectory.bang_bang_snap import bang_bang_snap, reached, snap_profile
from flexros.trajectory.limits import Limits

CIRCLE = Limits(20.0, 600.0, 36000.0, 2.16e6)
sizes = st.floats(-3.0, 3.0).map(lambda exponent: 10.0**exponent)
maybe_infinite = st.one_of(st.just(math.inf), sizes)
some_limits = st.builds(Limits, maybe_infinite, maybe_infinite, maybe_infinite, sizes)


def rounding(distance: float, limits: Limits) -> float:
    """Share of a snap pulse that times near the end of the motion are rounded by, with some reserve."""
    profile = snap_profile(distance, limits)
    return 1e-12 + 10.0 * float(np.finfo(float).eps) * profile.duration / profile.snap_time


def test_circle_test_of_paper_b() -> None:
    profile = snap_profile(2 * np.pi, CIRCLE)
    assert profile.snap_time == pytest.approx(1 / 60, rel=1e-14)
    assert (profile.jerk_time, profile.acceleration_time) == (0.0, 0.0)
    assert profile.duration == pytest.approx(np.pi / 10 + 4 / 60, rel=1e-14)
    assert round(profile.duration, 5) == 0.38083
    assert profile.snap == pytest.approx(2.16e6, rel=1e-14)


def test_pattern_of_the_circle_test() -> None:
    law = bang_bang_snap(2 * np.pi, CIRCLE)
    snap = law.coefficients[:, 4] * 24.0 / 2.16e6
    np.testing.assert_allclose(snap, [1, -1, -1, 1, 0, -1, 1, 1, -1], atol=1e-14)
    np.testing.assert_allclose(law.knots[:5] * 60, [0, 1, 2, 3, 4], atol=1e-12)
    np.testing.assert_allclose((law.duration - law.knots[:-6:-1]) * 60, [0, 1, 2, 3, 4], atol=1e-12)
    cruise = law.evaluate(np.array([0.2]))[:, 0]
    assert cruise[1:] == pytest.approx([20.0, 0.0, 0.0, 0.0], abs=1e-12)


@pytest.mark.slow
@settings(max_examples=300, deadline=None, derandomize=True)
@given(sizes, some_limits)
def test_limits_are_kept_and_the_distance_met(distance: float, limits: Limits) -> None:
    law = bang_bang_snap(distance, limits)
    t = np.unique(np.concatenate([np.linspace(a, b, 60) for a, b in zip(law.knots[:-1], law.knots[1:], strict=True)]))
    values = law.evaluate(t)
    for order, limit in enumerate(limits.values, start=1):
        assert np.max(np.abs(values[order])) <= limit * (1.0 + rounding(distance, limits))
    assert law.evaluate(np.array([law.duration]))[0, 0] == distance
    assert np.all(np.diff(values[0]) >= -1e-12 * distance)


@pytest.mark.slow
@settings(max_examples=300, deadline=None, derandomize=True)
@given(sizes, some_limits)
def test_three_derivatives_are_continuous_at_every_knot(distance: float, limits: Limits) -> None:
    law = bang_bang_snap(distance, limits)
    top = reached(snap_profile(distance, limits))
    assert np.all(np.diff(law.knots) > 0.0)
    for i, knot in enumerate(law.knots[1:-1]):
        for order, size in enumerate((distance, top.speed, top.acceleration, top.jerk)):
            before, after = (
                np.polynomial.Polynomial(law.coefficients[k]).deriv(order)(knot - law.origins[k])
                if order
                else np.polynomial.Polynomial(law.coefficients[k])(knot - law.origins[k])
                for k in (i, i + 1)
            )
            assert abs(after - before) <= 10.0 * size * rounding(distance, limits)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(sizes, some_limits)
def test_reached_values_are_those_of_the_law(distance: float, limits: Limits) -> None:
    law = bang_bang_snap(distance, limits)
    values = law.evaluate(np.concatenate((law.knots, law.knots[:-1] + 0.5 * np.diff(law.knots), [0.5 * law.duration])))
    top = reached(snap_profile(distance, limits))
    np.testing.assert_allclose(np.max(np.abs(values[1:]), axis=1), top.values, rtol=1e-9)


@pytest.mark.parametrize(
    ("distance", "limits", "phases"),
    [
        (1e-6, Limits(1, 10, 100, 1000), "snap"),
        (1e-3, Limits(1, 100, 1, 1000), "snap jerk"),
        (1.0, Limits(10, 1, 2, 1000), "snap jerk acceleration"),
        (9.0, Limits(1, 1, 2, 1000), "snap jerk acceleration cruise"),
        (9.0, Limits(1, 100, 1, 1000), "snap jerk cruise"),
        (9.0, Limits(0.01, 100, 100, 1000), "snap cruise"),
        (9.0, Limits(10, 1, 1000, 1000), "snap acceleration"),
        (9.0, Limits(1, 1, 1000, 1000), "snap acceleration cruise"),
    ],
)
def test_degenerate_cases_leave_phases_out(distance: float, limits: Limits, phases: str) -> None:
    profile = snap_profile(distance, limits)
    lengths = {
        "snap": profile.snap_time,
        "jerk": profile.jerk_time,
        "acceleration": profile.acceleration_time,
        "cruise": profile.cruise_time,
    }
    assert " ".join(name for name, length in lengths.items() if length > 0.0) == phases


def test_short_move_needs_the_known_time() -> None:
    assert bang_bang_snap(8e-4, Limits(snap=1.0)).duration == pytest.approx(8 * 1e-4**0.25, rel=1e-12)


def brute_force_duration(distance: float, limits: Limits) -> float:
    """Shortest duration over all symmetric profiles, as a geometric program in log lengths (convex)."""
    speed, acceleration, jerk, snap = limits.values
    bounds = np.log(np.array([jerk, acceleration, speed]) / snap)
    constraints = [{"type": "eq", "fun": lambda v: np.sum(v) - np.log(distance / snap)}]
    for k in range(3):
        constraints.append({"type": "ineq", "fun": lambda v, k=k: bounds[k] - np.sum(v[: k + 1])})
        constraints.append({"type": "ineq", "fun": lambda v, k=k: v[k + 1] - np.log(np.sum(np.exp(v[: k + 1])))})
    best = math.inf
    for guess in np.random.default_rng(1).normal(scale=2.0, size=(6, 4)):
        result = minimize(
            lambda v: np.log(np.sum(np.exp(v))), guess, constraints=constraints, method="SLSQP",
            options={"maxiter": 500, "ftol": 1e-13},
        )  # fmt: skip
        worst = min(float(np.min(c["fun"](result.x))) for c in constraints[1:])
        if result.success and worst > -1e-8 and abs(constraints[0]["fun"](result.x)) < 1e-8:
            best = min(best, float(np.exp(result.fun)))
    return best


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_no_symmetric_profile_is_faster(seed: int) -> None:
    rng = np.random.default_rng(seed)
    distance, *values = 10.0 ** rng.uniform(-1.5, 1.5, size=5)
    limits = Limits(*values)
    best = brute_force_duration(distance, limits)
    assert math.isfinite(best)
    assert snap_profile(distance, limits).duration == pytest.approx(best, rel=1e-5)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(sizes, some_limits, st.integers(1, 4))
def test_looser_limits_are_never_slower(distance: float, limits: Limits, which: int) -> None:
    looser = Limits(*(value * (2.0 if k == which else 1.0) for k, value in enumerate(limits.values, start=1)))
    assert snap_profile(distance, looser).duration <= snap_profile(distance, limits).duration * (1 + 1e-12)


def test_snap_limit_is_needed() -> None:
    with pytest.raises(InputError, match="has no snap limit, allowed is a finite limit above 0 .*; give the snap"):
        bang_bang_snap(1.0, Limits(1.0, 1.0, 1.0))


@pytest.mark.parametrize("distance", [0.0, -1.0, math.nan, math.inf])
def test_impossible_distance_is_refused(distance: float) -> None:
    with pytest.raises(InputError, match="distance of the move is .* allowed is a finite number above 0"):
        bang_bang_snap(distance, CIRCLE)
