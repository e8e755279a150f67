"""Time since the start of a log: nanosecond stamps to seconds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.time_series import Log


def start_stamp(log: Log) -> int:
    """Return the stamp that counts as time 0 of a log [ns]: the first of joint_states, else the first of any topic."""
    if len(log.joint_states.stamp):
        return int(log.joint_states.stamp[0])
    others = (log.joint_commands, log.joint_reference, log.tool_pose, log.tool_reference)
    return min((int(one.stamp.min()) for one in others if one is not None and len(one.stamp)), default=0)


def elapsed_seconds(stamp: IntArray, start: int) -> FloatArray:
    """Convert stamps to seconds since `start`; the difference is taken in whole nanoseconds, so none is lost.

    Args:
        stamp: Stamps [ns], shape (n,).
        start: Stamp that counts as time 0 [ns].

    Returns:
        Time [s], shape (n,).
    """
    return np.asarray((stamp - start) * 1e-9, dtype=np.float64)
