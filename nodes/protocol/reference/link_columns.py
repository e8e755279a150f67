"""The motion of the links as further joints of a reference chunk, whose fields are positions and velocities only."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

ORDERS = {"link": 0, "link_acceleration": 2, "link_snap": 4}
"""Suffix of the further joints -> derivative in `positions`; `velocities` hold the next one."""


def names_with_links(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the motors, then those of the further joints, e.g. "motor_1.link_acceleration"."""
    return (*names, *(f"{name}.{suffix}" for suffix in ORDERS for name in names))


def with_links(values: FloatArray, links: FloatArray, ahead: int) -> FloatArray:
    """Append the columns of the links to those of the motors.

    Args:
        values: Positions or velocities of the motors, shape (n, M).
        links: Positions of the links and four derivatives, shape (n, 5, M).
        ahead: 0 for positions, 1 for velocities, whose snap is followed by zeros.
    """
    more = np.concatenate([links, np.zeros((len(links), 1, links.shape[2]))], axis=1)
    return np.hstack([values, *(more[:, order + ahead] for order in ORDERS.values())])


def links_of(positions: FloatArray, velocities: FloatArray, n_motors: int) -> FloatArray:
    """Return the positions of the links and four derivatives, shape (n, 5 M), from the columns of a chunk."""
    columns = []
    for place, order in enumerate(ORDERS.values(), 1):
        rows = slice(place * n_motors, (place + 1) * n_motors)
        columns += [positions[:, rows], velocities[:, rows]][: min(2, 5 - order)]
    return np.hstack(columns)
