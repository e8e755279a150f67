"""Preparation of the search for causes: the base of all fits, the rows of estimates, the scales of the log."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.candidates.competitors import competitors
from flexros.gap.candidates.scales import scales_of
from flexros.gap.deadline import Deadline
from flexros.gap.fit.linearisation import linearise
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.settings import DiagnosisSettings
from flexros.random_streams import generator
from flexros.record.missing_samples import long_holes
from flexros.record.prescribed_motion import without_prescribed

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import IntArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.residuals.fit_data import FitData

BY_CHANCE = 2.0
"""Standard deviations by which parts of a log differ by chance [1]: 95 %."""
ROWS_STREAM = 21
"""Stream of random numbers that draws the prediction errors of the estimates."""


def prepare_search(
    null: NullFit,
    settings: DiagnosisSettings | None = None,
    progress: Callable[[str, float], None] | None = None,
    deadline: Deadline | None = None,
    base: CandidateFit | None = None,
    *,
    left_before: float | None = None,
) -> Search:
    """Prepare the fits of candidates to one log.

    Args:
        null: The fitted nominal model.
        settings: Settings of the diagnosis.
        progress: Called with the name of a step and the share of it that is done.
        deadline: When the search ends; default: once it is complete.
        base: The fit around which candidates are screened; default: that of the nominal model.
        left_before: What the base left in the same log tied more closely, where an earlier search ended with it [1].

    Raises:
        InputError: The settings name an effect or a motor that does not exist.
    """
    settings = settings or DiagnosisSettings()
    data, fit = null.data, null.fit if base is None else base
    # the way through a pause is faster than any motion
    known = data.counted if long_holes(data.record.valid).any() and data.counted.any() else slice(None)
    return Search(
        null=null,
        base=fit,
        base_residual=fit.residual(data),
        tolerance_slopes=linearise(fit.predictor, data, fit.theta).slopes[:, fit.predictor.n_effect :]
        if len(fit.deviations)
        else None,
        rows=_rows(data, settings.search.screened_values),
        scales=scales_of(
            null.model.robot,
            fit.states(data)[known],
            without_prescribed(data.record).torque[known],
            data.record.prescribed,
            data.record.sample_time,
        ),
        distance=_distances(data),
        chance=partial(_chance, data),
        settings=settings,
        left_before=left_before,
        competitors=competitors(null.model.robot, settings.search, data.record.prescribed),
        threads=settings.cores,
        progress=progress,
        deadline=deadline or Deadline(),
    )


def _rows(data: FitData, most: int) -> IntArray:
    """Choose prediction errors that are spread evenly over the log, drawn so that no period is favoured."""
    every = np.flatnonzero(data.used)
    if len(every) <= most:
        return every
    return np.sort(generator(0, ROWS_STREAM).choice(every, size=most, replace=False))


def _distances(data: FitData) -> Callable[[CandidateFit, CandidateFit], float]:
    """Return the function that computes the distance of two fits, and keeps it, as it costs two predictions."""
    known: dict[frozenset[CandidateFit], float] = {}

    def distance(fit: CandidateFit, other: CandidateFit) -> float:
        pair = frozenset((fit, other))
        if pair not in known:
            known[pair] = float(np.sum((fit.residual(data) - other.residual(data)) ** 2))
        return known[pair]

    return distance


def _chance(data: FitData, fit: CandidateFit, other: CandidateFit) -> float:
    """Return what the sums of squares of two fits of a measured log may differ by without evidence [1].

    What explanations of a machine leave is not white, and lasts for a part of a motion: parts of the log tell by how
    much their difference is an accident. Tolerated numbers were weighed by what was left before the search, which is
    more than at its end.

    Args:
        data: The log.
        fit: One fit.
        other: The other one.
    """
    number = max(2, math.ceil(data.record.n_samples * data.record.sample_time / data.settings.prediction_gap.block))
    first, second = (data.squares_in_time(one.residual(data), number) for one in (fit, other))
    by_parts = float(np.std(first - second, ddof=1)) * math.sqrt(number)
    return BY_CHANCE * by_parts + (data.misfit - 1) * abs(fit.prior_penalty - other.prior_penalty)
