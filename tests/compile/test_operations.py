from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest

from flexros.compile import compile_function
from flexros.compile.operations import ARITHMETIC, COMPARISONS, LIBRARY, LOGIC, ROUTINES

x, y = ca.SX.sym("x"), ca.SX.sym("y")
EXPRESSIONS: dict[int, ca.SX] = {
    ca.OP_ADD: x + y, ca.OP_SUB: x - y, ca.OP_MUL: x * y, ca.OP_DIV: x / y, ca.OP_NEG: -x, ca.OP_SQ: x * x,
    ca.OP_TWICE: 2 * x, ca.OP_INV: 1 / x, ca.OP_SQRT: ca.sqrt(x), ca.OP_FABS: ca.fabs(x), ca.OP_FLOOR: ca.floor(x),
    ca.OP_CEIL: ca.ceil(x), ca.OP_COPYSIGN: ca.copysign(x, y), ca.OP_SIGN: ca.sign(x), ca.OP_FMIN: ca.fmin(x, y),
    ca.OP_FMAX: ca.fmax(x, y), ca.OP_LT: x < y, ca.OP_LE: x <= y, ca.OP_EQ: x == y, ca.OP_NE: x != y,
    ca.OP_NOT: ca.logic_not(x), ca.OP_AND: ca.logic_and(x, y), ca.OP_OR: ca.logic_or(x, y),
    ca.OP_IF_ELSE_ZERO: ca.if_else(x, y, 0), ca.OP_SIN: ca.sin(x), ca.OP_COS: ca.cos(x), ca.OP_EXP: ca.exp(x),
    ca.OP_TANH: ca.tanh(x), ca.OP_LOG: ca.log(x), ca.OP_LOG1P: ca.log1p(x), ca.OP_EXPM1: ca.expm1(x),
    ca.OP_POW: x**y, ca.OP_CONSTPOW: x**2.5, ca.OP_TAN: ca.tan(x), ca.OP_ASIN: ca.asin(x),
    ca.OP_ACOS: ca.acos(x), ca.OP_ATAN: ca.atan(x), ca.OP_ATAN2: ca.atan2(x, y), ca.OP_SINH: ca.sinh(x),
    ca.OP_COSH: ca.cosh(x), ca.OP_ASINH: ca.asinh(x), ca.OP_ACOSH: ca.acosh(x), ca.OP_ATANH: ca.atanh(x),
    ca.OP_ERF: ca.erf(x), ca.OP_FMOD: ca.fmod(x, y), ca.OP_REMAINDER: ca.remainder(x, y), ca.OP_HYPOT: ca.hypot(x, y),
}  # fmt: skip
POINTS = [-2.5, -1.0, -0.7, -0.0, 0.0, 0.3, 0.7, 1.0, 1.5, 3.0]


def test_every_operation_of_the_tables_has_an_expression_here() -> None:
    known = {*ARITHMETIC, *LIBRARY, *COMPARISONS, *LOGIC, *ROUTINES, ca.OP_IF_ELSE_ZERO}
    assert set(EXPRESSIONS) == known


@pytest.mark.slow
@pytest.mark.parametrize("operation", EXPRESSIONS)
def test_operation_equals_the_virtual_machine(operation: int) -> None:
    function = ca.Function("f", [x, y], [EXPRESSIONS[operation]])
    used = [function.instruction_id(k) for k in range(function.n_instructions())]
    assert operation in used or (operation, ca.OP_MUL in used) == (ca.OP_TWICE, True)  # some releases multiply by two
    a, b = (grid.ravel() for grid in np.meshgrid(POINTS, POINTS))
    expected = np.array([float(function(one, two)) for one, two in zip(a, b, strict=True)])
    compiled = compile_function(function)
    actual = np.array([compiled([one], [two])[0][0] for one, two in zip(a, b, strict=True)])
    np.testing.assert_allclose(actual, expected, rtol=1e-15, atol=0)


@pytest.mark.slow
@pytest.mark.parametrize("operation", EXPRESSIONS)
def test_operation_has_the_same_bits_in_lanes(operation: int) -> None:
    function = ca.Function("f", [x, y], [EXPRESSIONS[operation]])
    single, lanes = compile_function(function), compile_function(function, lanes=8)
    a, b = np.array(POINTS[:8]), np.array(POINTS[2:])
    actual = lanes(a[np.newaxis], b[np.newaxis])[0][0]
    np.testing.assert_array_equal(actual, [single([one], [two])[0][0] for one, two in zip(a, b, strict=True)])


@pytest.mark.parametrize("expression", [ca.fmin(x, y), ca.fmax(x, y)])
@pytest.mark.parametrize("values", [(math.nan, 1.0), (1.0, math.nan)])
def test_limits_let_not_a_number_through(expression: ca.SX, values: tuple[float, float]) -> None:
    compiled = compile_function(ca.Function("f", [x, y], [expression]))
    assert math.isnan(compiled([values[0]], [values[1]])[0][0])


def test_branch_that_is_not_taken_may_be_infinite() -> None:
    compiled = compile_function(ca.Function("f", [x], [ca.if_else(x > 0, ca.log(x), 1 / x)]))
    assert compiled([0.0])[0][0] == math.inf
    assert compiled([1.0])[0][0] == 0.0


def test_choice_between_comparisons_needs_no_numbers() -> None:
    condition = ca.logic_and(x > 0, ca.logic_or(ca.logic_not(y < 1), x > 2))
    compiled = compile_function(ca.Function("f", [x, y], [ca.if_else(condition, 5, 6), condition + 1]))
    assert [compiled([a], [b])[0][0] for a, b in ((1, 0), (1, 2), (3, 0), (-1, 2))] == [6, 5, 5, 6]
    assert compiled([1], [2])[1][0] == 2
