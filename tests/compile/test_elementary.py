from __future__ import annotations

import math
from decimal import Decimal, localcontext

import casadi as ca
import numpy as np
import pytest

from flexros.compile import CompiledFunction, compile_function
from flexros.compile.elementary import SINCOS_RANGE

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798")


def compiled(lanes: int = 1) -> CompiledFunction:
    x = ca.SX.sym("x")
    return compile_function(
        ca.Function("f", [x], [ca.sin(x), ca.cos(x), ca.exp(x), ca.tanh(x), ca.log(x)]), lanes=lanes
    )


@pytest.fixture(scope="module")
def elementary() -> CompiledFunction:
    return compiled()


def sine(x: float, shift: int = 0) -> Decimal:
    """sin(x + shift pi/2) by Taylor series in 60 digits."""
    with localcontext() as context:
        context.prec = 60
        angle = (Decimal(x) + shift * PI / 2) % (2 * PI)
        angle = angle - 2 * PI if angle > PI else angle
        term, total, k = angle, angle, 1
        while abs(term) > Decimal("1e-55"):
            term = -term * angle * angle / ((k + 1) * (k + 2))
            total += term
            k += 2
        return total


def tanh(x: float) -> Decimal:
    with localcontext() as context:
        context.prec = 60
        e = (2 * Decimal(x)).exp()
        return (e - 1) / (e + 1)


def ulps(value: float, exact: Decimal) -> float:
    return float(abs(Decimal(value) - exact) / Decimal(math.ulp(float(exact))))


def test_sine_and_cosine_are_within_one_ulp(elementary: CompiledFunction) -> None:
    rng = np.random.default_rng(1)
    for x in np.concatenate([rng.uniform(-4, 4, 200), rng.uniform(-1e5, 1e5, 200), rng.uniform(-1.6e6, 1.6e6, 100)]):
        s, c, *_ = elementary(np.array([x]))
        assert ulps(s[0], sine(x)) < 1.0
        assert ulps(c[0], sine(x, 1)) < 1.0


def test_sine_and_cosine_keep_all_digits_near_multiples_of_a_right_angle(elementary: CompiledFunction) -> None:
    for k in [*range(1, 60), 11, 344, 51819, 573204, 1_000_000]:
        x = float(PI / 2 * k)
        s, c, *_ = elementary(np.array([x]))
        assert ulps(s[0], sine(x)) < 1.0
        assert ulps(c[0], sine(x, 1)) < 1.0


@pytest.mark.parametrize("x", [SINCOS_RANGE * 1.001, -1e9, 1e22, 1e300])
def test_angles_beyond_the_range_are_answered_by_the_mathematical_library(
    elementary: CompiledFunction, x: float
) -> None:
    s, c, *_ = elementary(np.array([x]))
    assert s[0] == math.sin(x)
    assert c[0] == math.cos(x)


def test_sine_of_negative_zero_is_negative_zero(elementary: CompiledFunction) -> None:
    assert math.copysign(1.0, elementary(np.array([-0.0]))[0][0]) == -1.0


def test_exponential_is_within_one_ulp(elementary: CompiledFunction) -> None:
    for x in np.random.default_rng(2).uniform(-700, 709, 300):
        assert ulps(elementary(np.array([x]))[2][0], Decimal(x).exp()) < 1.0


@pytest.mark.parametrize(("x", "value"), [(710.0, math.inf), (-746.0, 0.0), (-745.0, 5e-324), (0.0, 1.0)])
def test_exponential_at_the_ends_of_the_range(elementary: CompiledFunction, x: float, value: float) -> None:
    assert elementary(np.array([x]))[2][0] == value


def test_logarithm_is_within_one_ulp(elementary: CompiledFunction) -> None:
    rng = np.random.default_rng(4)
    for x in [*rng.uniform(0.5, 2.0, 300), *10.0 ** rng.uniform(-307, 308, 200), 5e-324, 1e-310, 1.0 + 2**-52]:
        assert ulps(elementary(np.array([x]))[4][0], Decimal(x).ln()) < 1.0


@pytest.mark.parametrize(("x", "value"), [(0.0, -math.inf), (-0.0, -math.inf), (1.0, 0.0), (math.inf, math.inf)])
def test_logarithm_at_the_ends_of_the_range(elementary: CompiledFunction, x: float, value: float) -> None:
    assert elementary(np.array([x]))[4][0] == value


def test_logarithm_of_a_negative_number_is_not_a_number(elementary: CompiledFunction) -> None:
    assert all(math.isnan(elementary(np.array([x]))[4][0]) for x in (-1.0, -5e-324, -math.inf))


def test_hyperbolic_tangent_is_within_three_ulps(elementary: CompiledFunction) -> None:
    rng = np.random.default_rng(3)
    for x in np.concatenate([rng.uniform(-25, 25, 200), 10.0 ** rng.uniform(-12, 0, 100)]):
        assert ulps(elementary(np.array([x]))[3][0], tanh(x)) < 3.0


def test_hyperbolic_tangent_saturates_with_sign(elementary: CompiledFunction) -> None:
    assert elementary(np.array([-800.0]))[3][0] == -1.0
    assert elementary(np.array([math.inf]))[3][0] == 1.0


def test_not_a_number_goes_through(elementary: CompiledFunction) -> None:
    assert all(math.isnan(value[0]) for value in elementary(np.array([math.nan])))


def test_infinite_angle_gives_not_a_number(elementary: CompiledFunction) -> None:
    s, c, *_ = elementary(np.array([math.inf]))
    assert math.isnan(s[0])
    assert math.isnan(c[0])


@pytest.mark.parametrize("lanes", [2, 4, 8, 16])
def test_lanes_give_the_same_bits(elementary: CompiledFunction, lanes: int) -> None:
    x = np.random.default_rng(4).uniform(-50, 50, lanes)
    x[0] = 1e10  # one lane takes the slow branch
    side_by_side = compiled(lanes)(x[np.newaxis, :])
    one_by_one = [elementary(x[k : k + 1]) for k in range(lanes)]
    for output in range(4):
        np.testing.assert_array_equal(side_by_side[output][0], [single[output][0] for single in one_by_one])
