"""Motors that move in one direction only, where what differs between directions does not show."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.record.record import Record

ONE_WAY = 0.96
"""Mean direction of a motion from which it is in one direction only [1] (chosen): less than 2 % of it is back."""


def moves_one_way(record: Record, motor: int) -> bool:
    """Return whether a motor moves in one direction only.

    Args:
        record: The log.
        motor: Number of the motor.
    """
    steps = np.diff(record.position[record.valid, motor])
    return bool(abs(steps.sum()) > ONE_WAY * np.abs(steps).sum())
