"""The share of a gap that a repair closes, with its interval."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np

from flexros.gap.held_out.errors_ahead import HORIZON, AheadErrors
from flexros.random_streams import generator

NOTHING = 0.005
"""Share of the gap below which an effect closes nothing [1] (chosen): it is written as 0 %."""
BOOTSTRAP_STREAM = 20
"""Stream of random numbers of the bootstrap."""


@dataclass(frozen=True)
class ClosedShare:
    """The share of a gap that a repair closes.

    Attributes:
        value: (E_before - E_after) / (E_before - 1), or such a difference of two repairs [1].
        interval: Its 95 % interval [1].
    """

    value: float
    interval: tuple[float, float]


def closed_fraction(before: AheadErrors, after: AheadErrors, sample_time: float) -> ClosedShare | None:
    """Compute the share of the gap that is closed, with a 95 % interval by a bootstrap over blocks of the log.

    Args:
        before: Errors of the nominal model.
        after: Errors of the repaired model in the same log.
        sample_time: Time between two samples [s].

    Returns:
        The share and its interval; None where the gap does not show in these errors.
    """
    return share_between(before, before, after, sample_time)


def share_between(
    before: AheadErrors, more: AheadErrors, less: AheadErrors, sample_time: float, *, floor: float = 1.0
) -> ClosedShare | None:
    """Compute the share of a gap between two repairs, with a 95 % interval by a bootstrap over blocks of the log.

    (E_more - E_less) / (E_before - 1), all of the same log. A gap within the noise of the floor has no share, which
    would be a quotient of noise. A model with a longer delay is predicted from a later instant on; blocks of the log
    that all three have count.

    Args:
        before: Errors of the nominal model.
        more: Errors of the model that leaves more.
        less: Errors of the one that leaves less.
        sample_time: Time between two samples [s].
        floor: Errors without a gap, over their floor; zero for a share of all errors [1].

    Returns:
        The share and its interval; None where the gap does not show in these errors, or not in the blocks that count.
    """
    settings, models = before.settings, (before, more, less)
    of_blocks = [(errors.starts * sample_time / settings.block).astype(int) for errors in models]
    blocks = reduce(np.intersect1d, of_blocks)
    own = list(zip(models, of_blocks, strict=True))
    least = settings.shows * sampling_error(before)
    if before.mean - floor <= least or not len(blocks):
        return None
    of_each = np.array([[errors.squares[where == block].mean() for block in blocks] for errors, where in own])
    counts = np.array([[np.sum(where == block) for block in blocks] for where in of_blocks], dtype=float)
    draws = generator(0, BOOTSTRAP_STREAM).integers(0, len(blocks), size=(settings.draws, len(blocks)))
    means = (of_each * counts)[:, draws].sum(axis=-1) / counts[:, draws].sum(axis=-1)
    means = means[:, means[0] - floor > least]
    if not means.size:
        return None
    low, high = np.quantile((means[1] - means[2]) / (means[0] - floor), [0.025, 0.975])
    return ClosedShare((more.mean - less.mean) / (before.mean - floor), (float(low), float(high)))


def sampling_error(errors: AheadErrors) -> float:
    """Return the standard deviation of E without a gap, from noise and the error of the floor.

    Overlapping windows count as one, which is conservative: most of the error is noise of the last sample.
    """
    independent = max(errors.squares.size * errors.settings.spacing / HORIZON, 1.0)
    return float(np.hypot(np.sqrt(2.0 / independent), errors.floor_error))
