"""H-infinity synthesis by SLICOT, with a tolerance on the norm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.control.design.continuous import ContinuousSystem
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

TOLERANCE = 0.1
"""Tolerance of the search for the least norm (chosen): without one SB10AD may not end, and the controller of the least
norm is badly conditioned."""
_LARGEST = 1e6
"""Norm from which the search starts [1]."""


def h_infinity(plant: ContinuousSystem, measured: int, controls: int, method: str) -> tuple[ContinuousSystem, float]:
    """Return the controller u = K y that nearly minimises the H-infinity norm, and a bound of the norm.

    Args:
        plant: From [disturbances, controls] to [weighted outputs, measurements].
        measured: Number of measurements, the last outputs.
        controls: Number of controls, the last inputs.
        method: Name of the design method, for error messages.

    Raises:
        InputError: slycot is missing, or there is no controller.
    """
    slycot = _slycot()
    A, B, C, D = (np.asarray(part, dtype=float, order="F") for part in (plant.A, plant.B, plant.C, plant.D))
    try:
        found = slycot.sb10ad(len(A), B.shape[1], len(C), controls, measured, _LARGEST, A, B, C, D, gtol=TOLERANCE)
    except (ArithmeticError, ValueError) as error:
        raise InputError(f"{method}: no controller was found ({error}); change the weights") from error
    gamma, parts = float(found[0]), [_matrix(part) for part in found[1:5]]
    return ContinuousSystem(*parts), gamma


def _matrix(part: Any) -> FloatArray:
    return np.asarray(part, dtype=float)


def _slycot() -> Any:
    try:
        import slycot  # here, because it loads slowly
    except ImportError as error:
        raise InputError("the package slycot is missing: python3 -m pip install 'flexros[design]'") from error
    return slycot
