"""A function of state, command and parameters, evaluated at many samples by one call of machine code."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.ir_text import IrBlock
from flexros.compile.module_builder import ModuleBuilder, check_lanes
from flexros.compile.sx_graph import dense_sx_function

if TYPE_CHECKING:
    import casadi as ca

    from flexros.arrays import FloatArray

RUN = "over_samples.run"
JOB_FIELDS = ("samples", "states", "commands", "parameters", "results")
"""Entries of the job of `over_samples.run`, 64 bits each: a number, then addresses."""


class FunctionOverSamples:
    """Machine code of y = f(x, u, p) over samples; thread-safe, releases the GIL.

    Args:
        function: CasADi function (x, u, p) -> y of column vectors.
        lanes: Parameter sets that are evaluated in parallel: 1, 2, 4, 8, 16.
    """

    def __init__(self, function: ca.Function, lanes: int) -> None:
        check_lanes(lanes)
        function = dense_sx_function(function)
        self.lanes = lanes
        self._sizes = [function.numel_in(k) for k in range(3)] + [function.numel_out(0)]
        builder = ModuleBuilder()
        symbol = builder.add_function(function, lanes=lanes)
        builder.add_text(_run_text(symbol, self._sizes, lanes))
        self._code = builder.build()
        self._run = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(self._code.address(RUN))

    def __call__(self, states: FloatArray, commands: FloatArray, parameters: FloatArray) -> FloatArray:
        """Evaluate the function at every sample.

        Args:
            states: x of every sample, shape (n, n_x, lanes).
            commands: u of every sample, shape (n, n_u, lanes).
            parameters: p, shape (n_p, lanes).

        Returns:
            y of every sample, shape (n, n_y, lanes).
        """
        n = len(states)
        n_x, n_u, n_p, n_y = self._sizes
        arrays = [
            np.ascontiguousarray(np.broadcast_to(array, shape), dtype=float)
            for array, shape in (
                (states, (n, n_x, self.lanes)),
                (commands, (n, n_u, self.lanes)),
                (parameters, (n_p, self.lanes)),
            )
        ]
        results = np.empty((n, n_y, self.lanes))
        job = np.array([n, *(array.ctypes.data for array in (*arrays, results))], dtype=np.int64)
        self._run(job.ctypes.data)
        return results


def _run_text(symbol: str, sizes: list[int], lanes: int) -> str:
    """Write `void run(job)`: a loop over the samples."""
    block = IrBlock(lanes)
    job = {
        name: block.value(
            f"load {'ptr' if index else 'i64'}, ptr {block.pointer('%job', index, 'i64')}, align 8"
        )
        for index, name in enumerate(JOB_FIELDS)
    }  # fmt: skip
    n_x, n_u, _, n_y = sizes
    with block.loop(0, job["samples"]) as k:
        x, u, y = (
            block.pointer(job[name], block.value(f"mul nsw i64 {k.index}, {width * lanes}"), "double")
            for name, width in (("states", n_x), ("commands", n_u), ("results", n_y))
        )
        block.emit(f"call void @{symbol}(ptr {x}, ptr {u}, ptr {job['parameters']}, ptr {y})")
    return f"define void @{RUN}(ptr %job) nounwind {{\nentry:\n{block.text()}\n  ret void\n}}"
