"""A tool measurement prepared for a fit, in the frame of the prediction; errors of the frame are projected out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.gap.residuals.tool_frame import correct_tool
from flexros.record.record import ToolRecord

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.gap.residuals.tool_frame import ToolFrame


LEAST_RATE = 200.0
"""Poses per second from which fourth-order differences show noise and no motion [Hz] (chosen)."""
NEAR = 0.2
"""Relative difference up to which the noise of a tracker counts as declared [1] (chosen)."""
CERTAIN = 3.0
"""Standard deviations by which a time offset must exceed a sample to be reported [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class ToolData:
    """Measured tool positions and their weight.

    Attributes:
        samples: Samples before and after the measurements, increasing, shape (n_p,).
        row: Row in `samples` of the sample before each measurement, shape (m,).
        share: Time since that sample over the sample time [1], shape (m,).
        position: Measured positions in the frame of the prediction [m], shape (m, 3).
        basis: Orthonormal basis of the effect of errors of frame, offsets and time, shape (3 m, k).
        spread: Standard deviation of the measurement [m].
        warnings: Warnings, one sentence each.
    """

    samples: IntArray
    row: IntArray
    share: FloatArray
    position: FloatArray
    basis: FloatArray
    spread: float
    warnings: tuple[str, ...] = ()

    def residuals(self, pose: FloatArray) -> FloatArray:
        """Weigh measured minus predicted positions, with the effect of frame and offsets projected out.

        Args:
            pose: Predicted poses of the samples, shape (n_p, 7, sets).

        Returns:
            Weighted residuals, shape (3 m, sets).
        """
        share = self.share[:, None, None]
        predicted = (1 - share) * pose[self.row, :3] + share * pose[self.row + 1, :3]
        error = (self.position[:, :, None] - predicted).reshape(-1, pose.shape[-1]) / self.spread
        result: FloatArray = error - self.basis @ (self.basis.T @ error)
        return result


def tracker_noise(tool: ToolRecord, declared: float) -> float:
    """Estimate the noise of a tracker [m]: as declared where the log agrees, otherwise from its fourth differences.

    Args:
        tool: The measurement; below 200 poses per second the declared noise is used, as motion would look like noise.
        declared: Standard deviation that the robot file declares [m].

    Raises:
        InputError: There is no noise.
    """
    rate = (len(tool.time) - 1) / max(float(tool.time[-1] - tool.time[0]), 1e-9) if len(tool.time) > 1 else 0.0
    if rate >= LEAST_RATE:
        moving = tool.position[:, np.ptp(tool.position, axis=0) > 0]
        differences = np.abs(np.diff(moving, 4, axis=0)) / np.sqrt(70.0)
        measured = 1.4826 * float(np.median(differences)) if differences.size else 0.0
        if measured > 0 and not abs(measured - declared) < NEAR * declared:
            return measured
    if declared <= 0:
        raise InputError("the robot file declares no noise of the tool tracker; give sensors.tool_noise in it")
    return declared


def tool_data(
    tool: ToolRecord, pose: FloatArray, counted: BoolArray, sample_time: float, spread: float, most: int
) -> ToolData:
    """Transform a tool measurement to the frame of a prediction.

    Args:
        tool: The measurement.
        pose: Poses that the nominal model predicts, shape (n, 7).
        counted: Samples whose prediction errors are used, shape (n,).
        sample_time: Time between two samples [s].
        spread: Standard deviation of the measurement [m].
        most: Largest number of poses used.

    Raises:
        InputError: There are too few poses within the log.
    """
    thin = slice(None, None, -(-len(tool.time) // most) or 1)
    tool = ToolRecord(tool.time[thin], tool.position[thin])
    turns = np.ptp(pose[:, 3:], axis=0).max() > 1e-6
    corrected = correct_tool(tool, pose[:, :3], sample_time, pose[:, 3:] if turns else None)
    at = corrected.time / sample_time
    sample = np.clip(at.astype(int), 0, len(pose) - 2)
    kept = counted[sample] & np.all(np.isfinite(corrected.position), axis=1)
    rows = np.repeat(kept, 3)
    basis = np.linalg.qr(corrected.basis[rows])[0] if corrected.basis.size else corrected.basis[rows]
    sample, share = sample[kept], (at - sample)[kept]
    samples = np.unique(np.concatenate([sample, sample + 1]))
    return ToolData(
        samples,
        np.searchsorted(samples, sample),
        share,
        corrected.position[kept],
        basis,
        spread,
        _of_time(corrected.frame, sample_time),
    )


def _of_time(frame: ToolFrame, sample_time: float) -> tuple[str, ...]:
    """Warn of a tracker whose stamps are off by significantly more than a sample."""
    late = frame.time_offset
    if not abs(late) - CERTAIN * frame.deviation[9] > sample_time:
        return ()
    return (
        f"the tool tracker appears to measure {1e3 * abs(late):.2g} ms {'later' if late > 0 else 'earlier'} than its "
        "stamps, which is corrected; check its clock: if it is right, this offset is part of the gap",
    )
