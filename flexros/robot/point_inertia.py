"""Inertia of a point mass."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


def point_inertia(mass: float, offset: FloatArray) -> FloatArray:
    """Return the inertia of a point mass at an offset, as Steiner's theorem adds it [kg m2], shape (3, 3).

    Args:
        mass: Mass [kg].
        offset: Place of the mass from the point about which it turns [m], shape (3,).
    """
    return np.asarray(mass * (offset @ offset * np.eye(3) - np.outer(offset, offset)))
