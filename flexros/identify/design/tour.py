"""The order in which positions are visited: a short tour, as moves between them measure nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray


def short_tour(start: FloatArray, positions: FloatArray) -> IntArray:
    """Order positions such that the sum of the largest joint moves is small: nearest neighbour, then 2-opt.

    Args:
        start: Initial gear coordinates [rad or m], shape (M,).
        positions: The positions [rad or m], shape (S, M).

    Returns:
        Order of the positions, shape (S,).
    """
    points = np.vstack([start, positions])
    distance = np.max(np.abs(points[:, None] - points), axis=2)
    order, left = [0], set(range(1, len(points)))
    while left:
        order.append(min(left, key=lambda point: (distance[order[-1], point], point)))
        left.remove(order[-1])
    length = _length(order, distance)
    improved = True
    while improved:
        improved = False
        for first in range(1, len(order) - 1):
            for last in range(first + 1, len(order)):
                turned = order[:first] + order[first : last + 1][::-1] + order[last + 1 :]
                if _length(turned, distance) < length - 1e-12:
                    order, length, improved = turned, _length(turned, distance), True
    return np.array(order[1:], dtype=np.int64) - 1


def _length(order: list[int], distance: FloatArray) -> float:
    return float(np.sum(distance[order[:-1], order[1:]]))
