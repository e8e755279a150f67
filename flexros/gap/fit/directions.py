"""Directions: how the weighted prediction errors change with a candidate in addition to a fit, or without an effect."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.prediction.compiled_plant import LANES, in_lanes

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData

HUGE = 1e15
"""Largest change of a weighted prediction error; beyond it a prediction has diverged [1]."""


@dataclass(frozen=True, eq=False)
class Directions:
    """Changes of the weighted prediction errors by a candidate in addition to a fit, one per initial value.

    Attributes:
        candidate: The candidate.
        starts: Its initial values in the units of the fit, shape (n_free, n_starts).
        changes: The changes, zero where the prediction diverges, in single precision, shape (n_rows, n_starts).
        usable: Whether the prediction does not diverge, shape (n_starts,).
    """

    candidate: Candidate
    starts: FloatArray
    changes: NDArray[np.float32]
    usable: BoolArray


def directions_of(
    predictor: Predictor,
    data: FitData,
    theta: FloatArray,
    own: FloatArray,
    residual: FloatArray,
    rows: IntArray,
    stop: Callable[[], bool] = lambda: False,
) -> Directions:
    """Predict a log with every initial value of one candidate in addition to a fit.

    Args:
        predictor: Predictor of the fit and the candidate, which comes last.
        data: Log and weights.
        theta: Parameters of the fit, shape (n_fitted,).
        own: Initial values of the candidate, shape (n_free, n_starts).
        residual: Weighted prediction errors of the fit, shape (n_values,).
        rows: Prediction errors that are kept, shape (n_rows,).
        stop: Asked between predictions; True leaves out the initial values that were not predicted until then.
    """
    before = predictor.n_effect - len(own)
    others = np.repeat(theta[:, None], own.shape[1], axis=1)
    starts = np.vstack([others[:before], own, others[before:]])
    changes = np.empty((len(rows), starts.shape[1]), dtype=np.float32)
    usable = np.zeros(starts.shape[1], dtype=bool)
    for begin in range(0, starts.shape[1], LANES):
        if begin and stop():
            own, changes, usable = own[:, :begin], changes[:, :begin], usable[:begin]
            break
        group = slice(begin, min(begin + LANES, starts.shape[1]))
        change = data.residuals(predictor, starts[:, group])[rows] - residual[rows, None]
        usable[group] = ~diverged(change)
        changes[:, group] = np.where(usable[group], change, 0.0)
    return Directions(predictor.hypothesis[-1], own, changes, usable)


def diverged(changes: FloatArray) -> BoolArray:
    """Return of which changes of the prediction errors the prediction has diverged, shape (sets,).

    Args:
        changes: Changes, shape (n_rows, sets).
    """
    with np.errstate(invalid="ignore"):
        return np.asarray(~np.all(np.abs(changes) < HUGE, axis=0))


def switched_off(fit: CandidateFit, data: FitData, residual: FloatArray, rows: IntArray) -> FloatArray:
    """Compute how the prediction errors change when each effect of a fit is switched off alone.

    Args:
        fit: The fit.
        data: Log and weights.
        residual: Its weighted prediction errors, shape (n_values,).
        rows: Prediction errors that are kept, shape (n_rows,).

    Returns:
        Changes, shape (n_rows, n_effects).
    """
    thetas = np.stack([fit.switched_off((candidate.name,)) for candidate in fit.hypothesis], axis=-1)
    return changes_of(fit, data, residual, rows, thetas)


def changes_of(
    fit: CandidateFit, data: FitData, residual: FloatArray, rows: IntArray, thetas: FloatArray
) -> FloatArray:
    """Compute how the prediction errors of a fit change with other parameters.

    Args:
        fit: The fit.
        data: Log and weights.
        residual: Its weighted prediction errors, shape (n_values,).
        rows: Prediction errors that are kept, shape (n_rows,).
        thetas: Parameters in the units of the fit, shape (n_fitted, sets).

    Returns:
        Changes, shape (n_rows, sets).
    """
    return np.concatenate(
        [data.residuals(fit.predictor, group)[rows] - residual[rows, None] for group in in_lanes(thetas)], axis=1
    )
