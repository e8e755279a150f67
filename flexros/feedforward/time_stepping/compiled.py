"""Time stepping in machine code: the loop over samples and Newton's iteration run without Python."""

from __future__ import annotations

import ctypes
from string import Template
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.ir_text import float_literal
from flexros.compile.linear_solver import add_lu_solver
from flexros.compile.module_builder import ModuleBuilder
from flexros.feedforward.time_stepping.stepping import (
    CHORD_ITERATIONS,
    FLOOR_FACTOR,
    MAX_ITERATIONS,
    STALE_ITERATIONS,
    StepLayout,
    SteppingResult,
)

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.compile.linear_solver import LuRoutines
    from flexros.feedforward.time_stepping.dae_equations import DaeEquations
    from flexros.feedforward.time_stepping.step_functions import StepFunctions


DRIVER = Template("""
define i64 @advance(i64 %n, ptr %state, ptr %outputs, ptr %tolerance, ptr %z, ptr %motors, ptr %iterations) nounwind {
entry:
  %prediction = alloca double, i64 $n_prediction, align 64
  %x_a = alloca double, i64 $n_unknowns, align 64
  %x_b = alloca double, i64 $n_unknowns, align 64
  %matrix = alloca double, i64 $n_matrix, align 64
  %residual = alloca double, i64 $n_unknowns, align 64
  %size_at = alloca double, align 8
  %after = alloca double, i64 $factors, align 64
  %after_rates = getelementptr double, ptr %after, i64 $rates
  %rates = getelementptr double, ptr %state, i64 $rates
  %factors = getelementptr double, ptr %state, i64 $factors
  %stale_at = getelementptr double, ptr %state, i64 $stale
  br label %samples

samples:
  %k = phi i64 [ 0, %entry ], [ %k_next, %accept ]
  %finished = icmp sge i64 %k, %n
  br i1 %finished, label %end, label %sample

sample:
  %row = mul nsw i64 %k, $n_motors
  %output = getelementptr double, ptr %outputs, i64 %row
  call void @predict(ptr %state, ptr %rates, ptr %prediction, ptr %x_a)
  br label %newton

newton:
  %iteration = phi i64 [ 1, %sample ], [ %iteration_next, %again ]
  %before = phi double [ $infinity, %sample ], [ %size, %again ]
  %x = phi ptr [ %x_a, %sample ], [ %x_new, %again ]
  %x_new = phi ptr [ %x_b, %sample ], [ %x, %again ]
  %stale = load double, ptr %stale_at, align 8
  %is_stale = fcmp une double %stale, 0.0
  %is_late = icmp sgt i64 %iteration, $chord_iterations
  %fresh = or i1 %is_stale, %is_late
  br i1 %fresh, label %renew, label %solve

renew:
  call void @matrix(ptr %x, ptr %prediction, ptr %matrix)
  %status = call i64 @$lu_factor(ptr %matrix, ptr %factors)
  store double 0.0, ptr %stale_at, align 8
  br label %solve

solve:
  call void @residual(ptr %x, ptr %prediction, ptr %output, ptr %residual)
  call void @$lu_solve(ptr %factors, ptr %residual, i64 1)
  call void @correct(ptr %x, ptr %residual, ptr %tolerance, ptr %x_new, ptr %size_at)
  %size = load double, ptr %size_at, align 8
  %small = fcmp ole double %size, 1.0
  %half = fmul double %before, 0.5
  %stuck = fcmp ogt double %size, %half
  %low = fcmp olt double %size, $floor_factor
  %at_floor = and i1 %stuck, %low
  %fresh_floor = and i1 %fresh, %at_floor
  %converged = or i1 %small, %fresh_floor
  br i1 %converged, label %accept, label %again

again:
  %iteration_next = add nsw i64 %iteration, 1
  %hopeless = icmp sgt i64 %iteration_next, $max_iterations
  %iterations_at = getelementptr i64, ptr %iterations, i64 %k
  store i64 %iteration_next, ptr %iterations_at, align 8
  br i1 %hopeless, label %end, label %newton

accept:
  %z_row = mul nsw i64 %k, $n_unknowns
  %z_at = getelementptr double, ptr %z, i64 %z_row
  %motors_row = mul nsw i64 %k, $n_results
  %motors_at = getelementptr double, ptr %motors, i64 %motors_row
  call void @finish(ptr %x_new, ptr %prediction, ptr %state, ptr %rates, ptr %after, ptr %after_rates, ptr %z_at,
                    ptr %motors_at)
  call void @llvm.memcpy.p0.p0.i64(ptr %state, ptr %after, i64 $n_moved, i1 false)
  %taken_at = getelementptr i64, ptr %iterations, i64 %k
  store i64 %iteration, ptr %taken_at, align 8
  %slow = icmp sgt i64 %iteration, $stale_iterations
  %stale_next = uitofp i1 %slow to double
  store double %stale_next, ptr %stale_at, align 8
  %k_next = add nsw i64 %k, 1
  br label %samples

end:
  ret i64 %k
}
""")
"""`i64 @advance(n, state, outputs, tolerance, z, motors, iterations)`: time stepping as LLVM text.

It returns the number of solved samples. Newton's iteration renews the factors, corrects x (the two buffers x_a and x_b
alternate) and ends by the criterion of `InterpretedStepper`. The new state is built in `after` and copied at the end of
a sample only, so that a failed sample leaves the state of the last solved one."""


class CompiledStepper:
    """Fast time stepping. The object keeps the machine code alive; calls release the interpreter lock.

    Args:
        equations: One step of the DAE.
        functions: Its arithmetic for one order and step size.
    """

    def __init__(self, equations: DaeEquations, functions: StepFunctions) -> None:
        builder = ModuleBuilder()
        lu = add_lu_solver(builder, equations.n_unknowns)
        self.layout = StepLayout(equations.n_unknowns, equations.n_coordinates, lu.work_size)
        self._n_motors = equations.n_motors
        steps = (functions.predict, functions.residual, functions.newton_matrix, functions.correct, functions.finish)
        for function in steps:
            builder.add_function(function)
        builder.add_text(_driver(self.layout, self._n_motors, lu))
        self._code = builder.build()
        prototype = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 6)
        self._advance = prototype(self._code.address("advance"))

    def advance(self, state: FloatArray, outputs: FloatArray, tolerance: FloatArray) -> SteppingResult:
        """Solve successive samples; see `flexros.feedforward.time_stepping.stepping.Stepper.advance`."""
        n, state = len(outputs), np.array(state, dtype=np.float64)
        outputs = np.ascontiguousarray(outputs, dtype=np.float64)
        tolerance = np.ascontiguousarray(tolerance, dtype=np.float64)
        z, motors = np.zeros((n, self.layout.n_unknowns)), np.zeros((n, 5, self._n_motors))
        iterations = np.zeros(n, dtype=np.int64)
        arrays = (state, outputs, tolerance, z, motors, iterations)
        failed = self._advance(n, *(array.ctypes.data for array in arrays))
        return SteppingResult(state, z, motors, iterations, int(failed))


def _driver(layout: StepLayout, n_motors: int, lu: LuRoutines) -> str:
    """Return the driver with the sizes of a robot."""
    nz, nq = layout.n_unknowns, layout.n_coordinates
    return DRIVER.substitute(
        n_prediction=nz + 2 * nq,
        n_unknowns=nz,
        n_matrix=nz * nz,
        n_motors=n_motors,
        n_results=5 * n_motors,
        n_moved=8 * layout.factors,
        rates=layout.rates,
        factors=layout.factors,
        stale=layout.stale,
        lu_factor=lu.factor,
        lu_solve=lu.solve,
        infinity=float_literal(float("inf")),
        floor_factor=float_literal(FLOOR_FACTOR),
        chord_iterations=CHORD_ITERATIONS,
        stale_iterations=STALE_ITERATIONS,
        max_iterations=MAX_ITERATIONS,
    )
