"""Functions that only call others, and the modules that share what is called."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.compile import machine_code
from flexros.compile.compiled_function import compile_function
from flexros.compile.module_builder import ModuleBuilder
from flexros.compile.nested_calls import is_long, nested_calls


def long_function(length: int = 2000) -> ca.Function:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 0)
    value = x
    for k in range(length // 6):
        value = ca.sin(value) + 0.1 * k * x
    return ca.Function("core", [x, p], [value, ca.sum1(value)])


def around(core: ca.Function, factor: float) -> ca.Function:
    """A function that scales what goes into a core, and adds what comes out."""
    x, y = ca.SX.sym("x", 3), ca.SX.sym("y", 3)
    before = ca.Function("before", [x], [factor * x])
    after = ca.Function("after", [x, y, ca.SX.sym("s")], [x + y])
    given, none = ca.MX.sym("x", 3), ca.MX.sym("p", 0)
    value, total = core(before(given), none)
    return ca.Function("whole", [given, none], [after(given, value, total)])


@pytest.mark.parametrize("lanes", [1, 8])
def test_same_values_as_written_out(lanes: int) -> None:
    """Written out, CasADi merges constants across the calls, which rounds otherwise."""
    nested = around(long_function(), 0.7)
    calls = [compile_function(function, lanes=lanes) for function in (nested, nested.expand())]
    x, none = (np.random.default_rng(0).normal(size=shape) for shape in calls[0].input_shapes)
    (found,), (expected,) = (call(x, none) for call in calls)
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-13)


def test_modules_share_what_they_call() -> None:
    core = long_function()
    assert is_long(core)
    builders = [ModuleBuilder(), ModuleBuilder()]
    for builder, factor in zip(builders, (0.5, 2.0), strict=True):
        builder.add_function(around(core, factor))
    symbols = {line for builder in builders for line in builder.text().splitlines() if line.startswith("declare void")}
    assert len(symbols) == 1
    assert all("define void @core" not in builder.text() for builder in builders)


def test_what_is_called_is_named_by_its_content() -> None:
    builder = ModuleBuilder()
    builder.add_function(around(long_function(2000), 1.0), name="first")
    builder.add_function(around(long_function(2600), 1.0), name="second")
    assert builder.text().count("declare void @core.") == 2
    builder.build()


def test_short_functions_are_written_out() -> None:
    builder = ModuleBuilder()
    builder.add_function(around(long_function(60), 1.0))
    assert "declare void" not in builder.text()


def test_other_functions_have_no_nested_calls() -> None:
    core, x = long_function(60), ca.MX.sym("x", 3)
    none = ca.MX.sym("p", 0)
    assert nested_calls(core) is None
    assert nested_calls(ca.Function("sum", [x, none], [core(x, none)[0] + x])) is None
    assert nested_calls(ca.Function("through", [x, none], [x, core(x, none)[0]])) is None
    twice = core(x, none)[0]
    assert nested_calls(ca.Function("twice", [x, none], [twice, twice])) is None


def test_what_is_called_is_compiled_once_though_nothing_is_kept_on_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLEXROS_CACHE", "off")
    made: list[str] = []
    compiled = machine_code._compiled
    monkeypatch.setattr(machine_code, "_compiled", lambda text, machine: made.append(text) or compiled(text, machine))
    core = long_function(2300)
    for factor in (0.25, 0.3, 0.35):
        compile_function(around(core, factor))
    assert len(made) == 4
