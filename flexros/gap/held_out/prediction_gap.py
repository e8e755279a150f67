"""How far robot and model are apart: prediction errors a tenth of a second ahead, over their floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.gap.schema import GapNumbers
from flexros.random_streams import generator

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.residuals.fit_data import FitData

METRIC = "mean squared prediction error 0.1 s ahead over its floor variance"
HORIZON = 0.1
"""How far ahead a prediction is made [s] (the contract)."""
SPACING = 0.025
"""Time between the starts of two predictions [s] (chosen)."""
BLOCK = 1.0
"""Length of the blocks that the interval is drawn from [s] (chosen)."""
DRAWS = 400
"""Draws of the bootstrap (chosen)."""
BOOTSTRAP_STREAM = 20
"""Stream of its random numbers."""
RUN_AWAY = 1e15
"""What a prediction counts that has run away: its error over the floor [1] (chosen)."""
SHOWS = 4.0
"""Standard deviations of E without gap by which a gap must exceed the floor to be told in shares (chosen)."""


@dataclass(frozen=True, eq=False)
class AheadErrors:
    """Squared errors of predictions a tenth of a second ahead, over the variance that noise alone gives them.

    Attributes:
        squares: Squared errors, each over its floor, shape (n_windows, M).
        starts: Samples at which the predictions start, shape (n_windows,).
        floor: Standard deviation of the errors without gap [rad or m], shape (M,).
        floor_error: Relative standard deviation of the variance of the noise [1]; zero where it is as declared.
    """

    squares: FloatArray
    starts: IntArray
    floor: FloatArray
    floor_error: float = 0.0

    @property
    def mean(self) -> float:
        """The gap E: mean over windows and motors; 1 without gap."""
        return float(self.squares.mean())

    def over(self, floor: FloatArray) -> AheadErrors:
        """Refer the errors to another floor [rad or m], shape (M,)."""
        return AheadErrors(self.squares * (self.floor / floor) ** 2, self.starts, floor, self.floor_error)


def errors_ahead(found: CandidateFit, data: FitData) -> AheadErrors:
    """Predict a log a tenth of a second ahead, again and again.

    Args:
        found: The model.
        data: The log; it need not be the one that the model was fitted to.

    Returns:
        Squared errors over their floor.

    Raises:
        InputError: The log is too short.
    """
    record, predictor = data.record, found.predictor
    horizon = max(1, round(HORIZON / record.sample_time))
    prediction = data.predict(predictor, found.theta[:, None], record_states=True)
    assert prediction.states is not None
    first = max(int(np.argmax(data.settled)), predictor.loop.line_length)
    starts = np.arange(first, record.n_samples - horizon, max(1, round(SPACING / record.sample_time)))
    counts = np.concatenate([[0], np.cumsum(~data.counted)])
    whole = starts[counts[starts + horizon + 1] == counts[starts]]
    # a log with losses everywhere has no whole stretch; then both ends count
    starts = whole if len(whole) else starts[data.counted[starts] & data.counted[starts + horizon]]
    if not len(starts):
        raise InputError(
            f"{record.name}: there is no stretch of {HORIZON:g} s behind the first {first * record.sample_time:.3g} s, "
            f"which the predictor needs to settle; the log has {record.duration:.3g} s, record a longer one"
        )
    positions = predictor.ahead(found.theta, record, prediction.states[:, :, 0], starts, horizon)
    floor = data.gain.ahead(horizon)
    errors = (record.position[starts + horizon] - positions) / floor
    squares = np.where(np.abs(errors) < RUN_AWAY, errors, RUN_AWAY) ** 2
    return AheadErrors(squares, starts, floor, data.measurement.floor_error)


@dataclass(frozen=True)
class ClosedShare:
    """The share of a gap that a repair closes.

    Attributes:
        value: (E_before - E_after) / (E_before - 1) [1].
        interval: Its 95 % interval [1].
    """

    value: float
    interval: tuple[float, float]


def closed_fraction(before: AheadErrors, after: AheadErrors, sample_time: float) -> ClosedShare | None:
    """Compute the share of the gap that is closed, with a 95 % interval from blocks of the log drawn anew.

    (E_before - E_after) / (E_before - 1), both of the same log. A gap that exceeds the floor by no more than
    noise may make it has no share: the quotient would be one of two noises.

    Args:
        before: Errors of the nominal model.
        after: Errors of the repaired model, at the same windows.
        sample_time: Time between two samples [s].

    Returns:
        The share and its interval; None where the gap does not show in these errors.
    """
    of_blocks = (before.starts * sample_time / BLOCK).astype(int)
    blocks = np.unique(of_blocks)
    sums = np.array([[one.squares[of_blocks == block].mean() for block in blocks] for one in (before, after)])
    counts = np.array([np.sum(of_blocks == block) for block in blocks], dtype=float)
    draws = generator(0, BOOTSTRAP_STREAM).integers(0, len(blocks), size=(DRAWS, len(blocks)))
    means = (sums * counts)[:, draws].sum(axis=-1) / counts[draws].sum(axis=-1)
    least = SHOWS * _sampling_error(before)
    if before.mean - 1.0 <= least:
        return None
    means = means[:, means[0] - 1.0 > least]
    low, high = np.quantile((means[0] - means[1]) / (means[0] - 1.0), [0.025, 0.975])
    return ClosedShare((before.mean - after.mean) / (before.mean - 1.0), (float(low), float(high)))


def gap_numbers(
    before: AheadErrors, after: AheadErrors | None, sample_time: float, rival: AheadErrors | None = None
) -> GapNumbers:
    """Put the gap before and after a repair into numbers.

    Args:
        before: Errors of the nominal model.
        after: Errors of the repaired model, at the same windows; None where nothing was repaired.
        sample_time: Time between two samples [s].
        rival: Errors of the best explanation that was not chosen.
    """
    share = None if after is None else closed_fraction(before, after, sample_time)
    return GapNumbers(
        metric=METRIC,
        unit="1",
        before=before.mean,
        after=None if after is None else after.mean,
        noise_floor=1.0,
        best_rival=None if rival is None else rival.mean,
        closed_fraction=None if share is None else share.value,
        interval=None if share is None else share.interval,
    )


def _sampling_error(errors: AheadErrors) -> float:
    """Return the standard deviation of E without gap, from noise and the error of the floor.

    Windows that overlap count as one, which is on the safe side: most of the error is noise of the last sample.
    """
    independent = max(errors.squares.size * SPACING / HORIZON, 1.0)
    return float(np.hypot(np.sqrt(2.0 / independent), errors.floor_error))
