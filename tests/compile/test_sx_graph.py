from __future__ import annotations

import casadi as ca
import pytest

from flexros.compile import compile_function
from flexros.compile.sx_graph import read_graph
from flexros.errors import InputError

x = ca.SX.sym("x", 2)


def test_equal_expressions_become_one_node() -> None:
    a, b = x[0], x[1]
    graph = read_graph(ca.Function("f", [x], [a * b + 1, ca.sin(b * a), 1 + b * a]))
    assert list(graph.operations).count(ca.OP_MUL) == 1
    assert list(graph.operations).count(ca.OP_ADD) == 1


def test_constants_are_distinguished_by_every_bit() -> None:
    graph = read_graph(ca.Function("f", [x], [x[0] * 0.1, x[0] * 0.10000000000000002, x[1] * 0.1]))
    assert sorted(graph.constants.values()) == [0.1, 0.10000000000000002]


def test_unknown_operation_is_named() -> None:
    function = ca.Function("odd", [x], [ca.erfinv(x[0])])
    with pytest.raises(InputError, match="'odd' uses the CasADi operation OP_ERFINV"):
        compile_function(function)


def test_free_variable_is_named() -> None:
    function = ca.Function("f", [x], [x * ca.SX.sym("gain")], {"allow_free": True})
    with pytest.raises(InputError, match=r"'f' depends on \['gain'\]"):
        compile_function(function)


def test_sparse_input_is_refused() -> None:
    matrix = ca.SX.sym("m", ca.Sparsity.diag(2))
    with pytest.raises(InputError, match="sparse inputs"):
        compile_function(ca.Function("f", [matrix], [ca.sum1(matrix)]))


def test_sparse_output_is_filled_with_zeros() -> None:
    compiled = compile_function(ca.Function("f", [x], [ca.diag(x)]))
    assert compiled([3.0, 4.0])[0].tolist() == [[3.0, 0.0], [0.0, 4.0]]


def test_mx_function_is_expanded() -> None:
    m = ca.MX.sym("m", 2, 2)
    compiled = compile_function(ca.Function("f", [m], [m @ m]))
    assert compiled([[1.0, 2.0], [3.0, 4.0]])[0].tolist() == [[7.0, 10.0], [15.0, 22.0]]


def test_mx_function_that_cannot_be_expanded_is_refused() -> None:
    class Opaque(ca.Callback):
        def eval(self, arguments: list[ca.DM]) -> list[ca.DM]:
            return arguments

    opaque, m = Opaque(), ca.MX.sym("m")
    opaque.construct("opaque", {})
    with pytest.raises(InputError, match="'f' (cannot be expanded|uses the CasADi operation OP_CALL)"):
        compile_function(ca.Function("f", [m], [opaque(m)]))
