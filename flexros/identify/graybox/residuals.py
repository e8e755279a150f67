"""Residuals of a fitted model per position, element and frequency band."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.response_noise import response_noise

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray, ComplexArray, FloatArray, IntArray
    from flexros.identify.graybox.fit import GrayBoxFit
    from flexros.identify.graybox.problem import GrayBoxProblem

BANDS = 4
"""Default number of frequency bands, with about equally many lines each (chosen)."""


@dataclass(frozen=True)
class ResidualCell:
    """Residual of one element of one position within one frequency band.

    Attributes:
        position: Index of the position, from 0.
        output: Name of the output.
        input: Name of the input.
        lowest: Lowest line of the band [Hz].
        highest: Highest line of the band [Hz].
        share: Share of the cost.
        chi_square: Squared residual over its variance, mean over the weighted lines, corrected for the number of fitted
            parameters; 1 is expected. NaN where no covariance is known or no line has a weight.
        largest: Largest residual in standard deviations, NaN as before.
        at: Frequency of the largest residual [Hz]; where no covariance is known, of the largest weighted error.
        error: Largest |G_measured - G_model| / |G_measured| among the weighted lines.
    """

    position: int
    output: str
    input: str
    lowest: float
    highest: float
    share: float
    chi_square: float
    largest: float
    at: float
    error: float


@dataclass(frozen=True, eq=False)
class ResidualReport:
    """Residuals of a fit.

    Attributes:
        cells: One entry per position, element and band; those without weight are left out.
        response: Responses of the fitted model, shape (Q, F, M, M).
        cost: Cost of the fit.
        chi_square: Mean of all squared residuals over their variance, corrected for the number of parameters; NaN where
            no covariance is known.
    """

    cells: tuple[ResidualCell, ...]
    response: ComplexArray
    cost: float
    chi_square: float

    def worst(self, count: int = 10) -> tuple[ResidualCell, ...]:
        """Return the cells with the largest shares of the cost, largest first."""
        return tuple(sorted(self.cells, key=lambda cell: -cell.share)[:count])


def residual_report(problem: GrayBoxProblem, fit: GrayBoxFit, bands: Sequence[float] | int = BANDS) -> ResidualReport:
    """Compare a fitted model with the measured responses.

    Args:
        problem: Measured responses, estimator and weights.
        fit: Result of the fit.
        bands: Edges between the frequency bands [Hz], or the number of bands of equally many lines.
    """
    measured, weights = problem.measured, problem.weights
    response = problem.model_at(fit.values).response(fit.values)
    used = weights > 0
    error = problem.estimator.error(np.where(used, measured, 1.0), np.where(used, response, 1.0))
    cost = weights * np.abs(error) ** 2
    misfit = _misfit(problem, response)
    correction = _correction(fit, int(np.count_nonzero(used)))
    total = max(float(np.sum(cost)), np.finfo(float).tiny)
    names = problem.responses[0]
    cells = []
    for lines in _lines_of_bands(problem.frequency, bands):
        for position, row, column in np.ndindex(len(measured), *measured.shape[2:]):
            cell = (position, lines, row, column)
            if np.any(used[cell]):
                figures = _figures(cost[cell], misfit[cell], np.abs(response[cell] / measured[cell] - 1.0), used[cell])
                cells.append(
                    ResidualCell(
                        position=position,
                        output=names.output_names[row],
                        input=names.input_names[column],
                        lowest=float(problem.frequency[lines[0]]),
                        highest=float(problem.frequency[lines[-1]]),
                        share=figures.cost / total,
                        chi_square=figures.chi_square * correction,
                        largest=figures.largest,
                        at=float(problem.frequency[lines[figures.line]]),
                        error=figures.error,
                    )
                )
    overall = float(np.mean(misfit[used] ** 2)) * correction
    return ResidualReport(tuple(cells), response, float(np.sum(cost)), overall)


@dataclass(frozen=True)
class _Figures:
    cost: float
    chi_square: float
    largest: float
    line: int
    error: float


def _figures(cost: FloatArray, misfit: FloatArray, error: FloatArray, used: BoolArray) -> _Figures:
    """Summarise the weighted lines of one cell."""
    known = bool(np.all(np.isfinite(misfit[used])))
    ranked = np.where(used, misfit if known else cost, -1.0)
    return _Figures(
        cost=float(np.sum(cost)),
        chi_square=float(np.mean(misfit[used] ** 2)),
        largest=float(np.max(misfit[used])),
        line=int(np.argmax(ranked)),
        error=float(np.max(error[used])),
    )


def _misfit(problem: GrayBoxProblem, response: ComplexArray) -> FloatArray:
    """Residuals in standard deviations of |G - G_0|, NaN where these are not known, shape (Q, F, M, M)."""
    rows = []
    for measured, model in zip(problem.responses, response, strict=True):
        noise = response_noise(measured)
        variance = np.full(model.shape, np.nan) if noise is None else noise.variance
        rows.append(np.abs(measured.response - model) / np.sqrt(np.where(variance > 0, variance, np.nan)))
    return np.stack(rows)


def _correction(fit: GrayBoxFit, count: int) -> float:
    """Elements over degrees of freedom; each real parameter takes half of a complex element."""
    free = len(fit.names) - int(np.count_nonzero(fit.at_bound))
    return count / max(count - 0.5 * free, 1.0)


def _lines_of_bands(frequency: FloatArray, bands: Sequence[float] | int) -> list[IntArray]:
    """Divide the lines among the bands; bands without lines are left out."""
    if isinstance(bands, int):
        parts = np.array_split(np.arange(len(frequency)), bands)
    else:
        parts = np.split(np.arange(len(frequency)), np.searchsorted(frequency, np.sort(bands)))
    return [part for part in parts if len(part)]
