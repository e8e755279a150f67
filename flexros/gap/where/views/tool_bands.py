"""Excess of the tool position by octave band and regime."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.where.bands import OctaveBands, fast_length
from flexros.gap.where.channel import Channel
from flexros.gap.where.views.position_bands import AbstractBands

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Self

    from flexros.gap.where.prediction_errors import PredictionErrors

REGIMES_OF_TOOL = ("all", "standstill", "reversal", "high speed", "vibration", "first third", "last third")
"""Regimes of the tool: a regime holds where it holds for any motor, standstill where it holds for all of them."""


class ToolBands(AbstractBands):
    """Excess of the components of the tool position, each in units of its rms, by octave band and regime."""

    name: ClassVar[str] = "tool_bands"
    rank: ClassVar[int] = 2
    words: ClassVar[Mapping[str, str]] = MappingProxyType({"tool": "excess"})

    @classmethod
    def of_log(cls, errors: PredictionErrors) -> Sequence[Self]:
        """Prepare the view of each component that is not zero throughout; none where no tool was measured."""
        record, error, motors = errors.record, errors.tool_error, errors.motors
        if error is None or record.tool is None or not len(error):
            return []
        time = record.tool.time
        sample_time = float(time[-1] - time[0]) / max(len(time) - 1, 1)
        bands = OctaveBands.of(fast_length(len(time)), sample_time, errors.settings.lowest_hz)
        time, error = time[-bands.n_samples :], error[-bands.n_samples :]
        n = motors[0].bands.n_samples
        rows = np.clip(np.round(time / record.sample_time).astype(int) - (record.n_samples - n), 0, n - 1)
        masks = {}
        for name in REGIMES_OF_TOOL:
            of_motors = [channel.masks[channel.regimes.index(name)][rows] > 0 for channel in motors]
            masks[name] = np.all(of_motors, axis=0) if name == "standstill" else np.any(of_motors, axis=0)
        rms = np.sqrt((error**2).mean(axis=0))
        valid = np.ones(len(time), dtype=bool)
        return [
            cls(
                Channel(
                    "tool",
                    error[:, axis] / rms[axis],
                    bands,
                    masks,
                    valid,
                    np.ones(2),
                    errors.settings,
                    estimate_level=True,
                )
            )
            for axis in np.flatnonzero(rms > 0)
        ]
