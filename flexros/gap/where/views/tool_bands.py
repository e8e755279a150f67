"""Excess of the tool position by octave band and regime."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.where.bands import fast_length_within
from flexros.gap.where.channel import sampled_channel
from flexros.gap.where.views.position_bands import AbstractBands

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Self

    from flexros.gap.where.prediction_errors import PredictionErrors


class ToolBands(AbstractBands):
    """Excess of the components of the tool position, each in units of its rms, by octave band and regime."""

    name: ClassVar[str] = "tool_bands"
    rank: ClassVar[int] = 2
    words: ClassVar[Mapping[str, str]] = MappingProxyType({"tool": "excess"})

    @classmethod
    def of_log(cls, errors: PredictionErrors) -> Sequence[Self]:
        """Prepare the view of each component that is not zero throughout; none where no tool was measured."""
        record, error, own = errors.record, errors.tool_error, (errors.motors, errors.record, errors.settings)
        if error is None or record.tool is None or not len(error):
            return []
        time, valid = record.tool.time, np.ones(len(error), dtype=bool)
        rms = np.sqrt((error[-fast_length_within(len(time)) :] ** 2).mean(axis=0))
        return [
            cls(sampled_channel("tool", time, error[:, axis] / rms[axis], valid, *own))
            for axis in np.flatnonzero(rms > 0)
        ]
