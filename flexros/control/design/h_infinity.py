"""H-infinity synthesis by SLICOT, at a stated distance above the least norm."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from flexros.control.design.continuous import ContinuousSystem
from flexros.errors import InputError

ABOVE_LEAST = 1.1
"""Norm of the synthesis over the least norm [1] (chosen): the controller of the least norm is badly conditioned."""
_LARGEST, _SMALLEST = 1e6, 1e-6
"""Norms between which the least one is searched for [1]."""
_TOLERANCE = 1e-4
"""Relative tolerance of the least norm [1] (chosen)."""


def h_infinity(plant: ContinuousSystem, measured: int, controls: int, method: str) -> tuple[ContinuousSystem, float]:
    """Return the controller u = K y whose H-infinity norm is a tenth above the least one, and the bound of its norm.

    SLICOT SB10AD returns controllers for bounds that they do not keep, so the norm of the closed loop is computed for
    each bound of the search.

    Args:
        plant: From [disturbances, controls] to [weighted outputs, measurements]; controls do not act on measurements
            at once.
        measured: Number of measurements.
        controls: Number of controls.
        method: Name of the method, for the error message.

    Raises:
        InputError: No stabilising controller was found, or slycot is missing.
    """
    slycot = _slycot()
    scaled = _scaled_states(plant)
    A, B, C, D = (np.asarray(part, order="F") for part in (scaled.A, scaled.B, scaled.C, scaled.D))

    def controller(bound: float) -> ContinuousSystem | None:
        try:
            found = slycot.sb10ad(len(A), B.shape[1], len(C), controls, measured, bound, A, B, C, D, job=4)
        except (ArithmeticError, ValueError):
            return None
        K = ContinuousSystem(*(np.asarray(part, dtype=float) for part in found[1:5]))
        return K if _norm(slycot, _closed(scaled, K, measured, controls)) <= bound else None

    least, below = _LARGEST, _SMALLEST
    while least > below * (1.0 + _TOLERANCE):
        middle = float(np.sqrt(least * below))
        if controller(middle) is None:
            below = middle
        else:
            least = middle
    bound = ABOVE_LEAST * least
    best = controller(bound)
    if best is None:
        raise InputError(f"{method}: no controller was found that is stable in the loop; change the weights")
    return best, bound


def _scaled_states(plant: ContinuousSystem) -> ContinuousSystem:
    """Scale each state so that it is as much excited as it is seen, which makes the diagonals of both Gramians alike.

    Without it, rounding errors decide where a badly conditioned plant has its least norm.
    """
    A, B, C = plant.A, plant.B, plant.C
    excited, seen = (
        np.abs(np.diag(solve_continuous_lyapunov(part, -source @ source.T))) for part, source in ((A, B), (A.T, C.T))
    )
    known = (excited > 0) & (seen > 0)
    size = np.divide(excited, seen, out=np.ones(len(A)), where=known) ** 0.25
    return ContinuousSystem(A / size[:, None] * size, B / size[:, None], C * size, plant.D)


def _closed(plant: ContinuousSystem, controller: ContinuousSystem, measured: int, controls: int) -> ContinuousSystem:
    """Return the plant with u = K y closed; controls do not act on measurements at once."""
    B, last_B = plant.B[:, :-controls], plant.B[:, -controls:]
    C, last_C = plant.C[:-measured], plant.C[-measured:]
    D, to_measured = plant.D[:-measured, :-controls], plant.D[-measured:, :-controls]
    of_controls = plant.D[:-measured, -controls:]
    K = controller
    return ContinuousSystem(
        np.block([[plant.A + last_B @ K.D @ last_C, last_B @ K.C], [K.B @ last_C, K.A]]),
        np.concatenate([B + last_B @ K.D @ to_measured, K.B @ to_measured]),
        np.hstack([C + of_controls @ K.D @ last_C, of_controls @ K.C]),
        D + of_controls @ K.D @ to_measured,
    )


def _norm(slycot: Any, system: ContinuousSystem) -> float:
    """Return the H-infinity norm of a system; infinite where it is unstable."""
    if np.linalg.eigvals(system.A).real.max() >= 0:
        return float("inf")
    n, (p, m) = len(system.A), system.D.shape
    A, B, C, D = (np.asarray(part, order="F") for part in (system.A, system.B, system.C, system.D))
    return float(slycot.ab13dd("C", "I", "S", "D", n, m, p, A, np.eye(n), B, C, D)[0])


def _slycot() -> Any:
    try:
        import slycot  # here, because it loads slowly
    except ImportError as error:
        raise InputError("the package slycot is missing: python3 -m pip install 'flexros[design]'") from error
    return slycot
