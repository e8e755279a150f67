"""A log as a fit sees it: with gain, start, and weights of its prediction errors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.gain import ObserverGain
    from flexros.gap.predictor import Predictor
    from flexros.gap.record import GapRecord
    from flexros.gap.tool_data import ToolData
    from flexros.gap.weights import Measurement


@dataclass(frozen=True, eq=False)
class FitData:
    """Log and what the fit needs to weigh its prediction errors.

    Attributes:
        record: The log.
        gain: Gain of the predictor.
        start: State of the robot before the first sample, shape (2 n_coordinates,).
        spread: Standard deviation of a prediction error without gap [rad or m], shape (n, M); infinite where a sample
            was not measured or the start has not decayed.
        measurement: Noise of the encoders.
        pose: Arm coordinates at which the gain was computed [rad or m], shape (N,); None for home.
        tool: What a tool tracker saw; None where there was none.
    """

    record: GapRecord
    gain: ObserverGain
    start: FloatArray
    spread: FloatArray
    measurement: Measurement
    tool: ToolData | None = None
    pose: FloatArray | None = None

    @property
    def n_values(self) -> int:
        """Number of prediction errors that count."""
        of_tool = 0 if self.tool is None else self.tool.position.size - self.tool.basis.shape[1]
        return int(np.isfinite(self.spread).sum()) + of_tool

    def residuals(self, predictor: Predictor, thetas: FloatArray) -> FloatArray:
        """Predict and weigh.

        Args:
            predictor: The hypothesis.
            thetas: Numbers, shape (n_fitted, sets) with at most `LANES` sets.

        Returns:
            Weighted prediction errors, each of variance 1 without gap: those of the motors one after the other, then
            those of the tool, shape (M n + 3 m, sets).
        """
        samples = None if self.tool is None else self.tool.samples
        prediction = predictor.predict(thetas, self.record, self.gain, self.start, pose_samples=samples)
        sets = thetas.shape[1]
        motors = self.weighted(prediction.innovation[:, :, :sets])
        if self.tool is None:
            return motors
        assert prediction.tool_pose is not None
        return np.vstack([motors, self.tool.residuals(prediction.tool_pose[:, :, :sets])])

    def weighted(self, innovation: FloatArray) -> FloatArray:
        """Weigh prediction errors.

        Args:
            innovation: Prediction errors [rad or m], shape (n, M, sets).

        Returns:
            Weighted prediction errors, shape (n M, sets); zero where they do not count.
        """
        n, M, sets = innovation.shape
        result = np.empty((M, n, sets))
        for motor in range(M):
            white = innovation[:, motor]
            if self.measurement.whitening.shape[1] > 1:
                white = lfilter(self.measurement.whitening[motor], [1.0], white, axis=0)
            np.multiply(white, self._weight[:, motor, None], out=result[motor])
        return result.reshape(M * n, sets)

    @cached_property
    def _weight(self) -> FloatArray:
        return 1.0 / self.spread
