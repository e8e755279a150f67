"""Tables with a row for each message of several topics, whose columns are empty in the rows of other messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.logs.foreign.usable_rows import MOST_LOST

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import BoolArray, FloatArray

TOGETHER = 0.5
"""Share of the values of a column in whose rows another one has values too, from which both are of one message [1]
(chosen)."""
APART = 0.1
"""The same below which they are of two (chosen): messages of the same time share a row."""
BETWEEN = 10
"""Most rows from message to message up to which those between are of others, though no column of these is read
(chosen)."""


def message_rows(columns: Mapping[str, FloatArray]) -> dict[str, BoolArray]:
    """Return the rows of the message of each column, for those that are empty in the rows of others, shape (n,) each.

    A value that is lost while others of its message are there stays one that is lost.

    Args:
        columns: Columns of a table by name, shape (n,) each; NaN where they are empty.
    """
    finite = {name: np.isfinite(values) for name, values in columns.items()}
    rows = {}
    for name, own in finite.items():
        if own.all() or not own.any():
            continue
        others = {other: mask for other, mask in finite.items() if len(mask) == len(own)}
        shared = {other: float(mask[own].mean()) for other, mask in others.items()}
        message = np.any([mask for other, mask in others.items() if shared[other] >= TOGETHER], axis=0)
        apart = any(share < APART for other, share in shared.items() if others[other].any())
        steps = np.diff(np.flatnonzero(message))  # rows from message to message
        between = len(steps) < (1 - MOST_LOST) * steps.sum() and steps.max() <= BETWEEN
        if not message.all() and (apart or between):
            rows[name] = message
    return rows
