"""Points, faces and turns of what is drawn: bars of an arm and ribbons of path errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.report.base import FACTORS

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray

SHOWN_SHARE = 0.1
"""Size of the largest magnified deviation, relative to what is drawn (chosen)."""
RIBBON_POINTS = 1500
"""Most points along a ribbon (chosen)."""


def magnification(deviation: float, extent: float) -> int:
    """Choose the factor at which a deviation is seen.

    Args:
        deviation: Largest deviation [m].
        extent: Size of what it is drawn on [m].

    Returns:
        The largest factor of `FACTORS` that draws it no larger than a tenth of the extent, at least 1.
    """
    return max((factor for factor in FACTORS if factor * deviation <= SHOWN_SHARE * extent), default=1)


def turned_z(directions: FloatArray) -> FloatArray:
    """Return the turns that bring the z axis onto directions.

    Args:
        directions: Directions, of any length above 0, shape (n, 3).

    Returns:
        Quaternions w, x, y, z [-], shape (n, 4).
    """
    unit = directions / np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-12)
    w = 1.0 + unit[:, 2]
    quaternion = np.column_stack([w, -unit[:, 1], unit[:, 0], np.zeros(len(unit))])
    quaternion[w < 1e-9] = [0.0, 1.0, 0.0, 0.0]
    return np.asarray(quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True))


def ribbon(base: FloatArray, deviation: FloatArray, factor: float) -> tuple[FloatArray, IntArray]:
    """Return a band between a path and its magnified error.

    Args:
        base: Points of the path [m], shape (n, 3).
        deviation: Error at each point [m], shape (n, 3).
        factor: Magnification.

    Returns:
        Corners [m], shape (2 n, 3): the path, then the magnified error; and triangles of corners, shape (2 n - 2, 3).
    """
    n = len(base)
    corners = np.concatenate([base, base + factor * deviation])
    row = np.arange(n - 1)
    faces = np.concatenate([np.stack([row, row + 1, row + n]), np.stack([row + 1, row + n + 1, row + n])], axis=1).T
    return corners, np.ascontiguousarray(faces)


def evenly(n: int, most: int = RIBBON_POINTS) -> IntArray:
    """Return at most `most` rows of n, first and last among them."""
    return np.unique(np.round(np.linspace(0, n - 1, min(n, most))).astype(np.int64))
