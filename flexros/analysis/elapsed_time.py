"""Conversion of nanosecond stamps to seconds since the start of a log."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.time_series import Log


def start_stamp(log: Log) -> int:
    """Return the stamp of time 0 of a log [ns]: the first of joint_states, else the first of any topic."""
    if len(log.joint_states.stamp):
        return int(log.joint_states.stamp[0])
    others = (log.joint_commands, log.joint_reference, log.tool_pose, log.tool_reference)
    return min((int(series.stamp.min()) for series in others if series is not None and len(series.stamp)), default=0)


def elapsed_seconds(stamp: IntArray, start: int) -> FloatArray:
    """Convert stamps to seconds since `start`; the difference is exact, in whole nanoseconds.

    Args:
        stamp: Stamps [ns], shape (n,).
        start: Stamp of time 0 [ns].

    Returns:
        Time [s], shape (n,).
    """
    return np.asarray((stamp - start) * 1e-9, dtype=np.float64)
