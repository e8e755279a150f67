"""How far robot and model are apart: prediction errors a tenth of a second ahead, over their floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.random_streams import generator

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.fit import Fit
    from flexros.gap.fit_data import FitData

HORIZON = 0.1
"""How far ahead a prediction is made [s] (the contract)."""
SPACING = 0.025
"""Time between the starts of two predictions [s] (chosen)."""
BLOCK = 1.0
"""Length of the blocks that the interval is drawn from [s] (chosen)."""
DRAWS = 400
BOOTSTRAP_STREAM = 20


@dataclass(frozen=True, eq=False)
class AheadErrors:
    """Squared errors of predictions a tenth of a second ahead, over the variance that noise alone gives them.

    Attributes:
        squares: Squared errors, each over its floor, shape (n_windows, M).
        starts: Samples at which the predictions start, shape (n_windows,).
        floor: Standard deviation of the errors without gap [rad or m], shape (M,).
    """

    squares: FloatArray
    starts: FloatArray
    floor: FloatArray

    @property
    def mean(self) -> float:
        """The gap E: mean over windows and motors; 1 without gap."""
        return float(self.squares.mean())

    def over(self, floor: FloatArray) -> AheadErrors:
        """Refer the errors to another floor [rad or m], shape (M,)."""
        return AheadErrors(self.squares * (self.floor / floor) ** 2, self.starts, floor)


def errors_ahead(found: Fit, data: FitData) -> AheadErrors:
    """Predict a log a tenth of a second ahead, again and again.

    Args:
        found: The model.
        data: The log; it need not be the one that the model was fitted to.

    Returns:
        Squared errors over their floor.
    """
    record, predictor = data.record, found.predictor
    horizon = max(1, round(HORIZON / record.sample_time))
    prediction = predictor.predict(found.theta[:, None], record, data.gain, data.start, record_states=True)
    assert prediction.states is not None
    first = max(min(data.gain.settling, record.n_samples // 4), predictor.loop.line_length)
    starts = np.arange(first, record.n_samples - horizon, max(1, round(SPACING / record.sample_time)))
    counts = np.concatenate([[0], np.cumsum(~record.valid)])
    starts = starts[counts[starts + horizon + 1] == counts[starts]]
    positions = predictor.ahead(found.theta, record, prediction.states[:, :, 0], starts, horizon)
    floor = data.gain.ahead(horizon)
    squares = ((record.position[starts + horizon] - positions) / floor) ** 2
    return AheadErrors(squares, starts, floor)


def closed_fraction(before: AheadErrors, after: AheadErrors, sample_time: float) -> tuple[float, tuple[float, float]]:
    """Compute the share of the gap that is closed, with a 95 % interval from blocks of the log drawn anew.

    (E_before - E_after) / (E_before - 1), both of the same log.

    Args:
        before: Errors of the nominal model.
        after: Errors of the repaired model, at the same windows.
        sample_time: Time between two samples [s].

    Returns:
        The share and its interval.
    """
    of_blocks = (before.starts * sample_time / BLOCK).astype(int)
    blocks = np.unique(of_blocks)
    sums = np.array([[one.squares[of_blocks == block].mean() for block in blocks] for one in (before, after)])
    counts = np.array([np.sum(of_blocks == block) for block in blocks], dtype=float)
    draws = generator(0, BOOTSTRAP_STREAM).integers(0, len(blocks), size=(DRAWS, len(blocks)))
    means = (sums * counts)[:, draws].sum(axis=-1) / counts[draws].sum(axis=-1)
    shares = (means[0] - means[1]) / np.maximum(means[0] - 1.0, 1e-12)
    low, high = np.quantile(shares, [0.025, 0.975])
    return _share(before.mean, after.mean), (float(low), float(high))


def _share(before: float, after: float) -> float:
    return (before - after) / max(before - 1.0, 1e-12)
