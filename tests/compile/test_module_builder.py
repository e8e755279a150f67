from __future__ import annotations

import ctypes

import casadi as ca
import numpy as np
import pytest

from flexros.compile import ModuleBuilder
from flexros.compile.ir_text import IrBlock
from flexros.errors import InputError

x = ca.SX.sym("x", 2)
TURN = ca.Function("turn", [x], [ca.vertcat(ca.cos(x[1]), ca.sin(x[0]))])


def test_driver_calls_a_function_without_leaving_machine_code() -> None:
    builder = ModuleBuilder()
    turn = builder.add_function(TURN)
    block = IrBlock()
    scratch = block.value("alloca double, i64 2")
    with block.loop(0, "%n"):
        block.emit(f"call void @{turn}(ptr %x, ptr {scratch})")
        for k in range(2):
            block.store(block.load(scratch, k), "%x", k)
    builder.add_text(f"define void @run(i64 %n, ptr %x) {{\nentry:\n{block.text()}\n  ret void\n}}")
    code = builder.build()
    state = np.array([0.3, 0.4])
    ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_void_p)(code.address("run"))(3, state.ctypes.data)
    expected = np.array([0.3, 0.4])
    for _ in range(3):
        expected = np.array([np.cos(expected[1]), np.sin(expected[0])])
    np.testing.assert_allclose(state, expected, rtol=1e-15)


def test_loop_carries_values_and_conditions_guard() -> None:
    block = IrBlock()
    with block.loop(1, "%n", carry=[("i64", "0")]) as k:
        k.next_values = [block.value(f"add i64 {k.values[0]}, {k.index}")]
    with block.when(block.value(f"icmp sgt i64 {k.values[0]}, 100")):
        block.emit("store i64 1, ptr %flag")
    block.leave_when(block.value(f"icmp eq i64 {k.values[0]}, 0"), "ret i64 -1")
    builder = ModuleBuilder()
    builder.add_text(f"define i64 @total(i64 %n, ptr %flag) {{\nentry:\n{block.text()}\n  ret i64 {k.values[0]}\n}}")
    code = builder.build()
    total = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p)(code.address("total"))
    flag = np.zeros(1, dtype=np.int64)
    assert [total(n, flag.ctypes.data) for n in (1, 5)] == [-1, 10]
    assert flag[0] == 0
    assert total(20, flag.ctypes.data) == 190
    assert flag[0] == 1


def test_functions_of_different_lanes_live_in_one_module() -> None:
    builder = ModuleBuilder()
    builder.add_function(TURN, name="one")
    builder.add_function(TURN, name="eight", lanes=8)
    code = builder.build()
    assert code.address("one") != code.address("eight")


def test_a_symbol_is_taken_once() -> None:
    builder = ModuleBuilder()
    builder.add_function(TURN)
    assert "turn" in builder
    with pytest.raises(InputError, match="already has a function 'turn'"):
        builder.add_function(TURN)


def test_a_name_that_is_no_symbol_is_refused() -> None:
    with pytest.raises(InputError, match="'a b' cannot name a compiled function"):
        ModuleBuilder().add_function(TURN, name="a b")


def test_unknown_symbol_has_no_address() -> None:
    builder = ModuleBuilder()
    builder.add_function(TURN)
    with pytest.raises(KeyError, match="other"):
        builder.build().address("other")
