"""Which of two fits predicts a log one sample ahead better, by more than chance."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.held_out.closed_share import BOOTSTRAP_STREAM
from flexros.random_streams import generator

if TYPE_CHECKING:
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData

CHANCE = 0.025
"""Quantile of a bootstrap below which a rise is chance [1]: the lower end of a 95 % interval."""


def surely_worse(fit: CandidateFit, other: CandidateFit, held: FitData) -> bool:
    """Return whether a fit predicts the held-out log one sample ahead worse than another one, by more than chance.

    That is by the 95 % interval of a bootstrap over blocks of the log, as `share_between` has it 0.1 s ahead. What
    differs at a tool and at further sensors counts as it is.

    Args:
        fit: The fit.
        other: The other one.
        held: The held-out log.
    """
    settings, record = held.settings.prediction_gap, held.record
    number = max(1, math.ceil(record.n_samples * record.sample_time / settings.block))
    worse, better = (one.residual(held) for one in (fit, other))
    rises = held.squares_in_time(worse, number) - held.squares_in_time(better, number)
    elsewhere = float(np.sum(worse**2) - np.sum(better**2) - rises.sum())
    draws = generator(0, BOOTSTRAP_STREAM).integers(0, number, size=(settings.draws, number))
    return not np.quantile(rises[draws].sum(axis=1), CHANCE) + elsewhere <= 0  # also where it diverged
