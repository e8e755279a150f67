"""Time stepping by the CasADi virtual machine and NumPy: cross-check and fallback of the compiled one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

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
    from flexros.feedforward.time_stepping.dae_equations import DaeEquations
    from flexros.feedforward.time_stepping.step_functions import StepFunctions


class InterpretedStepper:
    """Slow time stepping with the same iteration as the compiled one.

    Args:
        equations: One step of the DAE.
        functions: Its arithmetic for one order and step size.
    """

    def __init__(self, equations: DaeEquations, functions: StepFunctions) -> None:
        n = equations.n_unknowns
        self.layout = StepLayout(n, equations.n_coordinates, n * n + n)
        self._n_motors = equations.n_motors
        self._functions = functions

    def advance(self, state: FloatArray, outputs: FloatArray, tolerance: FloatArray) -> SteppingResult:
        """Solve successive samples; see `flexros.feedforward.time_stepping.stepping.Stepper.advance`."""
        layout, f = self.layout, self._functions
        n, state = len(outputs), state.copy()
        z, motors = np.zeros((n, layout.n_unknowns)), np.zeros((n, 5, self._n_motors))
        iterations = np.zeros(n, dtype=np.int64)
        failed = n
        for k, output in enumerate(outputs):
            differences, rates = state[: layout.rates], state[layout.rates : layout.factors]
            prediction, x = (np.array(part).ravel() for part in f.predict(differences, rates))
            x, iterations[k] = self._solve(state, x, prediction, output, tolerance)
            if iterations[k] > MAX_ITERATIONS:
                failed = k
                break
            results = [np.array(part).ravel() for part in f.finish(x, prediction, differences, rates)]
            state[: layout.rates], state[layout.rates : layout.factors], z[k] = results[:3]
            motors[k] = results[3].reshape(5, self._n_motors)
            state[layout.stale] = float(iterations[k] > STALE_ITERATIONS)
        return SteppingResult(state, z, motors, iterations, failed)

    def _solve(
        self, state: FloatArray, x: FloatArray, prediction: FloatArray, output: FloatArray, tolerance: FloatArray
    ) -> tuple[FloatArray, int]:
        """Solve one step for the correction x; more than MAX_ITERATIONS iterations mean failure."""
        from scipy.linalg import lu_factor, lu_solve  # loads slowly

        layout, f = self.layout, self._functions
        n, before = layout.n_unknowns, np.inf
        for iteration in range(1, MAX_ITERATIONS + 1):
            fresh = iteration > CHORD_ITERATIONS or bool(state[layout.stale])
            if fresh:
                matrix = np.array(f.newton_matrix(x, prediction))
                if not np.isfinite(matrix).all():
                    break
                factors, pivots = lu_factor(matrix)
                state[layout.factors : layout.stale] = np.concatenate([factors.ravel(), pivots])
                state[layout.stale] = 0.0
            kept = state[layout.factors : layout.stale]
            factors, pivots = kept[: n * n].reshape(n, n), kept[n * n :].astype(np.int32)
            residual = np.array(f.residual(x, prediction, output)).ravel()
            correction = lu_solve((factors, pivots), residual, check_finite=False)
            x, part = (np.array(part).ravel() for part in f.correct(x, correction, tolerance))
            size = float(part[0])
            if size <= 1.0 or (fresh and 0.5 * before < size < FLOOR_FACTOR):
                return x, iteration
            before = size
        return x, MAX_ITERATIONS + 1
