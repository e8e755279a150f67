"""Speed of the compiler and its code compared with CasADi's virtual machine, LAPACK and NumPy, in the same run.

Prints one JSON object per line. Evaluations are repeated inside machine code, so that no Python is timed with them.
"""

from __future__ import annotations

import ctypes
import json
import time
from functools import partial
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
from scipy.linalg.lapack import dgesv

from flexros.compile import LoopFunctions, LoopInputs, ModuleBuilder, compile_function, compile_loop
from flexros.compile.ir_text import IrBlock
from flexros.compile.linear_solver import add_lu_solver
from flexros.robot import load_robot

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from flexros.arrays import FloatArray

T = 5e-4


def seconds(work: Callable[[], object], repeats: int = 15) -> float:
    """Return the shortest time of several runs [s]; other load on the machine only increases it."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def repeated_call(builder: ModuleBuilder, call: str, pointers: int, turns: int) -> Callable[..., None]:
    """Compile a driver that makes a call many times; `call` names its pointers %a0, %a1, ..."""
    block = IrBlock()
    with block.loop(0, turns):
        block.emit(call)
    parameters = ", ".join(f"ptr %a{k}" for k in range(pointers))
    builder.add_text(f"define void @repeat({parameters}) {{\nentry:\n{block.text()}\n  ret void\n}}")
    code = builder.build()
    function = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * pointers)(code.address("repeat"))

    def run(*arrays: np.ndarray, code: object = code) -> None:
        function(*(a.ctypes.data for a in arrays))

    return run


def evaluation_seconds(function: ca.Function, lanes: int, turns: int = 500) -> float:
    """Time one evaluation of a compiled function [s]."""
    builder = ModuleBuilder()
    symbol = builder.add_function(function, lanes=lanes)
    pointers = function.n_in() + function.n_out()
    arguments = ", ".join(f"ptr %a{k}" for k in range(pointers))
    run = repeated_call(builder, f"call void @{symbol}({arguments})", pointers, turns)
    rng = np.random.default_rng(0)
    sizes = [function.numel_in(k) for k in range(function.n_in())]
    arrays = [0.1 * rng.normal(size=(size, lanes)) for size in sizes]
    arrays += [np.zeros((function.numel_out(k), lanes)) for k in range(function.n_out())]
    return seconds(lambda: run(*arrays)) / turns


def virtual_machine_seconds(function: ca.Function, turns: int = 200) -> float:
    """Time one evaluation by CasADi itself [s], through its buffer interface."""
    rng = np.random.default_rng(0)
    interface: tuple[Any, Any] = function.buffer()  # the stubs ask for sizes that the views already carry
    buffer, call = interface
    keep = [0.1 * rng.normal(size=max(1, function.numel_in(k))) for k in range(function.n_in())]
    for k, array in enumerate(keep):
        buffer.set_arg(k, array.data)
    results = [np.zeros(function.numel_out(k)) for k in range(function.n_out())]
    for k, array in enumerate(results):
        buffer.set_res(k, array.data)

    def run() -> None:
        for _ in range(turns):
            call()

    return seconds(run) / turns


def function_rows(name: str) -> Iterator[dict[str, Any]]:
    """Time compiling and evaluating the derivative of a robot."""
    f = load_robot(name).model.derivative
    case = f"{name} derivative, {f.n_instructions()} instructions"
    yield row(case, "compile", seconds(lambda: compile_function(f), 3), "s", 0.5)
    peer = virtual_machine_seconds(f)
    yield row(case, "evaluation, CasADi virtual machine", 1e9 * peer, "ns")
    for lanes in (1, 4, 8):
        took = evaluation_seconds(f, lanes) / lanes
        yield row(case, f"evaluation per lane, {lanes} lanes", 1e9 * took, "ns")
        yield row(case, f"times faster than the virtual machine, {lanes} lanes", peer / took, "1")


def latency_rows(name: str) -> Iterator[dict[str, Any]]:
    """Time the way from a robot's name to the first simulated sample."""

    def first() -> None:
        model = load_robot(name).model
        m = model.derivative.numel_in(1)
        c, r, y, g = ca.SX.sym("c", 0), ca.SX.sym("r", 3 * m), ca.SX.sym("y", m), ca.SX.sym("g", m)
        controller = ca.Function("controller", [c, r, y, g], [g * (r[:m] - y) + r[2 * m :], c])
        loop = LoopFunctions(model.derivative, model.encoder, model.tool_pose, controller)
        kernel = compile_loop(loop, sample_time=T)
        inputs = LoopInputs(reference=np.zeros((1, 3 * m)), gains=np.ones(m))
        kernel.run(kernel.initial_state(np.zeros(kernel.sizes.state)), 1, inputs)

    yield row(name, "robot file to first sample of a closed loop", seconds(first, 3), "s", 0.5)


def lapack_seconds(matrix: FloatArray, rhs: FloatArray) -> float:
    """Time the solution of a system by LAPACK [s]."""
    return seconds(lambda: [dgesv(matrix, rhs) for _ in range(20)]) / 20


def solver_rows() -> Iterator[dict[str, Any]]:
    """Time factorisation and solution of dense systems, compared with LAPACK."""
    for n in (5, 24, 60, 122):
        turns = max(1, 200_000 // n**2)
        builder = ModuleBuilder()
        lu = add_lu_solver(builder, n)
        run = repeated_call(builder, f"call i64 @{lu.factor_solve}(ptr %a0, ptr %a1)", 2, turns)
        matrix = np.asfortranarray(np.linalg.qr(np.random.default_rng(n).normal(size=(n, n)))[0])
        rhs = np.ones(n)  # solved again and again: an orthogonal matrix keeps its size
        took = seconds(partial(run, matrix, rhs)) / turns
        peer = lapack_seconds(matrix, rhs)
        yield row(f"{n} x {n} system", "factor and solve", 1e9 * took, "ns")
        yield row(f"{n} x {n} system", "times faster than LAPACK dgesv from SciPy", peer / took, "1")


def sine_rows() -> Iterator[dict[str, Any]]:
    """Time sine and cosine of eight angles."""
    x = ca.SX.sym("x", 8)
    took = evaluation_seconds(ca.Function("f", [x], [ca.sin(x), ca.cos(x)]), 1) / 8
    angles = np.random.default_rng(0).normal(size=80_000)
    peer = seconds(lambda: (np.sin(angles), np.cos(angles))) / len(angles)
    yield row("sine and cosine of one angle", "evaluation", 1e9 * took, "ns")
    yield row("sine and cosine of one angle", "times faster than NumPy", peer / took, "1")


def call_rows() -> Iterator[dict[str, Any]]:
    """Time the way from Python into a compiled function."""
    x = ca.SX.sym("x")
    compiled = compile_function(ca.Function("f", [x], [x]))
    given, result = np.zeros(1), np.zeros(1)
    bound = compiled.bind(given, result)
    yield row("call from Python", "bound", 1e6 * seconds(lambda: [bound() for _ in range(1000)]) / 1000, "us", 0.5)
    yield row("call from Python", "arrays", 1e6 * seconds(lambda: [compiled(given) for _ in range(1000)]) / 1000, "us")


def row(case: str, what: str, value: float, unit: str, goal: float | None = None) -> dict[str, Any]:
    """Return one row of the results."""
    return {"case": case, "what": what, "value": float(f"{value:.4g}"), "unit": unit, "goal": goal}


def main() -> None:
    """Print all rows."""
    parts = [function_rows("e12"), function_rows("six_axis"), latency_rows("e12"), latency_rows("six_axis")]
    rows = [one for part in (*parts, solver_rows(), sine_rows(), call_rows()) for one in part]
    print(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
