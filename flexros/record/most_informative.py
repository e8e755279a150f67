"""The most informative part of a long log about friction and inertia, for work whose cost grows with the samples."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.missing_samples import bridged_motion
from flexros.record.smoothing import motion_cutoff, smooth_motion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record

BLOCKS = 20
"""Steps by which a part is moved along the log, in one length of it [1] (chosen)."""
NOTHING = 1e-6
"""Information that is added to each part, over the mean of all, so that a motor at rest tells nothing [1]."""


def most_informative(record: Record, most: int, reason: str = "") -> Record:
    """Cut out the part of a log that determines inertia, friction and offset of its motors best.

    With the regressors W = [a, v, sign v, 1] of a motor, each over its rms in the whole log, the part has the largest
    sum over the motors of log det W'W (D-optimality, Atkinson 1992). It is contiguous, as a prediction needs.

    Args:
        record: The log.
        most: Most samples of all motors together.
        reason: Why no more are used, for the warning.

    Returns:
        The part, with a warning that says which it is; the log itself where it is no longer.
    """
    n, M = record.position.shape
    length = max(most // M, BLOCKS)
    if n <= length:
        return record
    step = length // BLOCKS
    information = _information(record, step)
    together = np.cumsum(np.concatenate([np.zeros_like(information[:1]), information]), axis=0)
    parts = together[BLOCKS:] - together[:-BLOCKS]
    scale = NOTHING * parts.mean(axis=0) + 1e-300 * np.eye(parts.shape[-1])
    best = int(np.argmax(np.linalg.slogdet(parts + scale * np.eye(parts.shape[-1]))[1].sum(axis=1)))
    part = record.part(best * step, best * step + length)
    T = record.sample_time
    warning = (
        f"the log lasts {n * T:.4g} s: the {length * T:.4g} s from {best * step * T:.4g} s on are used, the "
        f"most informative ones about inertia and friction{f' {reason}' if reason else ''}"
    )
    return replace(part, warnings=(*part.warnings, warning))


def _information(record: Record, step: int) -> FloatArray:
    """Compute W'W of each block of `step` samples for each motor, shape (n_blocks, M, 4, 4)."""
    cutoff = motion_cutoff(record.sample_time)
    n_blocks = len(record.position) // step
    result: FloatArray = np.empty((n_blocks, record.position.shape[1], 4, 4))
    for motor, position in enumerate(bridged_motion(record.position, record.valid).T):
        _, speed, acceleration = smooth_motion(position[:, None], record.sample_time, cutoff)[:, :, 0]
        moving = np.abs(speed) > 0.01 * np.abs(speed).max()
        W = np.stack([acceleration, speed, np.sign(speed) * moving, np.ones_like(speed)], axis=-1)
        W = W / np.maximum(np.sqrt(np.mean(W**2, axis=0)), 1e-300) * record.valid[:, None]
        blocks = W[: n_blocks * step].reshape(n_blocks, step, 4)
        result[:, motor] = blocks.transpose(0, 2, 1) @ blocks
    return result
