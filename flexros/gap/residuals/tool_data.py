"""A tool measurement as a fit sees it: brought to the frame of the prediction, with what the frame may still be off."""

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
"""Poses per second from which differences of fourth order show noise and no motion [Hz] (chosen)."""
NEAR = 0.2
"""Relative difference up to which the noise of a tracker counts as declared [1] (chosen)."""
CERTAIN = 3.0
"""Standard deviations by which a time offset must exceed a sample to be told [1] (chosen)."""
MOST_POSES = 10_000
"""Most measurements of the tool that count; of more of them every second, third ... is taken (chosen)."""


@dataclass(frozen=True, eq=False)
class ToolData:
    """Measured tool positions and their weight.

    Attributes:
        samples: Samples before and behind the measurements, increasing, shape (n_p,).
        place: Row of the sample before each measurement in `samples`, shape (m,).
        share: Share of the sample time behind it [1], shape (m,).
        position: Measured positions in the frame of the prediction [m], shape (m, 3).
        basis: Orthonormal basis of what errors of frame, offsets and time add, shape (3 m, k).
        spread: Standard deviation of the measurement [m].
        warnings: What was noticed, a sentence each.
    """

    samples: IntArray
    place: IntArray
    share: FloatArray
    position: FloatArray
    basis: FloatArray
    spread: float
    warnings: tuple[str, ...] = ()

    def residuals(self, pose: FloatArray) -> FloatArray:
        """Weigh measured minus predicted positions, with what frame and offsets explain taken off.

        Args:
            pose: Predicted poses of the samples, shape (n_p, 7, sets).

        Returns:
            Weighted residuals, shape (3 m, sets).
        """
        share = self.share[:, None, None]
        predicted = (1 - share) * pose[self.place, :3] + share * pose[self.place + 1, :3]
        error = (self.position[:, :, None] - predicted).reshape(-1, pose.shape[-1]) / self.spread
        result: FloatArray = error - self.basis @ (self.basis.T @ error)
        return result


def tracker_noise(tool: ToolRecord, declared: float) -> float:
    """Tell the noise of a tracker: as declared where the log agrees, else as its fourth differences show it.

    Args:
        tool: What the tracker saw; where it saw fewer than 200 poses per second, motion would pass for noise.
        declared: Standard deviation that the robot file states [m].

    Returns:
        Standard deviation [m].

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
        raise InputError("the robot file states no noise of the tool tracker; give sensors.tool_noise in it")
    return declared


def tool_data(tool: ToolRecord, pose: FloatArray, counted: BoolArray, sample_time: float, spread: float) -> ToolData:
    """Bring a tool measurement to the frame of a prediction.

    Args:
        tool: What the tracker saw.
        pose: Poses that the nominal model predicts, shape (n, 7).
        counted: Samples whose prediction errors count, shape (n,).
        sample_time: Time between two samples [s].
        spread: Standard deviation of the measurement [m].

    Raises:
        InputError: There are too few poses within the record.
    """
    thin = slice(None, None, -(-len(tool.time) // MOST_POSES) or 1)
    tool = ToolRecord(tool.time[thin], tool.position[thin])
    turns = np.ptp(pose[:, 3:], axis=0).max() > 1e-6
    corrected = correct_tool(tool, pose[:, :3], sample_time, pose[:, 3:] if turns else None)
    place = corrected.time / sample_time
    sample = np.clip(place.astype(int), 0, len(pose) - 2)
    kept = counted[sample] & np.all(np.isfinite(corrected.position), axis=1)
    rows = np.repeat(kept, 3)
    basis = np.linalg.qr(corrected.basis[rows])[0] if corrected.basis.size else corrected.basis[rows]
    sample, share = sample[kept], (place - sample)[kept]
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
    """Warn of a tracker whose stamps are off by more than a sample, beyond doubt."""
    late = frame.time_offset
    if not abs(late) - CERTAIN * frame.deviation[9] > sample_time:
        return ()
    return (
        f"the tool tracker seems to see the tool {1e3 * abs(late):.2g} ms {'later' if late > 0 else 'earlier'} than "
        "its stamps say, which is taken off; check its clock, for where it is right this is a part of the gap",
    )
