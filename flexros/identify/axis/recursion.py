"""Recursion over all samples of a record, in machine code where possible."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.machine_code import can_compile
from flexros.compile.module_builder import ModuleBuilder

if TYPE_CHECKING:
    import casadi as ca

    from flexros.arrays import FloatArray

_DRIVER = """
define void @recursion(i64 %n, ptr %state, ptr %inputs, ptr %parameters, ptr %outputs, ptr %next) nounwind {{
entry:
  br label %head
head:
  %k = phi i64 [ 0, %entry ], [ %after, %turn ]
  %more = icmp slt i64 %k, %n
  br i1 %more, label %turn, label %end
turn:
  %in = mul nsw i64 %k, {inputs}
  %out = mul nsw i64 %k, {outputs}
  %input = getelementptr double, ptr %inputs, i64 %in
  %output = getelementptr double, ptr %outputs, i64 %out
  call void @step(ptr %state, ptr %input, ptr %parameters, ptr %next, ptr %output)
  call void @llvm.memcpy.p0.p0.i64(ptr %state, ptr %next, i64 {bytes}, i1 false)
  %after = add nsw i64 %k, 1
  br label %head
end:
  ret void
}}
"""


class Recursion:
    """Runs s_(k+1), o_k = step(s_k, i_k, p) over a record.

    Args:
        step: CasADi function (s, i, p) -> (s_next, o), all columns.
    """

    def __init__(self, step: ca.Function) -> None:
        self._sizes = step.numel_in(0), step.numel_in(1), step.numel_out(1)
        if not can_compile():
            self._step: ca.Function | None = step
            return
        self._step = None
        state, inputs, outputs = self._sizes
        builder = ModuleBuilder()
        builder.add_function(step, name="step")
        builder.add_text(_DRIVER.format(inputs=inputs, outputs=outputs, bytes=8 * state))
        self._code = builder.build()
        pointers = [ctypes.c_void_p] * 5
        self._run = ctypes.CFUNCTYPE(None, ctypes.c_int64, *pointers)(self._code.address("recursion"))

    def run(self, state: FloatArray, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Run over a record; the GIL is released during the run.

        Args:
            state: State before the first sample, shape (n_s,).
            inputs: Inputs, shape (n, n_i).
            parameters: Parameters, shape (n_p,).

        Returns:
            Outputs, shape (n, n_o).
        """
        if self._step is not None:
            whole = self._step.mapaccum(len(inputs))
            held = np.repeat(parameters[:, None], len(inputs), axis=1)
            result: FloatArray = whole(state, inputs.T, held)[1].full().T
            return result
        state, inputs, parameters = (
            np.array(array, dtype=np.float64, order="C") for array in (state, inputs, parameters)
        )
        outputs, following = np.empty((len(inputs), self._sizes[2])), np.empty_like(state)
        arrays = (state, inputs, parameters, outputs, following)
        self._run(len(inputs), *(array.ctypes.data for array in arrays))
        return outputs
