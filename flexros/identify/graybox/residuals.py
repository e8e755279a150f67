"""Where a fitted model and the measured responses differ: per position, element and frequency band."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.response_noise import response_noise

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray, ComplexArray, FloatArray, IntArray
    from flexros.identify.graybox.fit import GrayBoxFit
    from flexros.identify.graybox.problem import GrayBoxProblem

BANDS = 4
"""Default number of frequency bands, with about equally many lines each (chosen)."""


@dataclass(frozen=True)
class ResidualCell:
    """What is left in one element of one position within one frequency band.

    Attributes:
        position: Number of the position, from 0.
        output: Name of the output.
        input: Name of the input.
        lowest: Lowest line of the band [Hz].
        highest: Highest line of the band [Hz].
        share: Share of the cost.
        chi_square: Squared misfit over its variance, mean over the lines that count and corrected for the number of
            fitted parameters; 1 to expect, NaN where no covariance is known or no line counts.
        largest: Largest misfit in standard deviations, NaN as before.
        at: Frequency of the largest misfit [Hz]; where no covariance is known, of the largest weighted error.
        error: Largest |G_measured - G_model| / |G_measured| among the lines that count.
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
    """What a fit leaves unexplained.

    Attributes:
        cells: One entry per position, element and band; those without weight are left out.
        response: Responses of the fitted model, shape (Q, F, M, M).
        cost: Cost of the fit.
        chi_square: Mean of all squared misfits over their variance, corrected for the number of parameters; NaN where
            no covariance is known.
    """

    cells: tuple[ResidualCell, ...]
    response: ComplexArray
    cost: float
    chi_square: float

    def worst(self, number: int = 10) -> tuple[ResidualCell, ...]:
        """Return the cells with the largest shares of the cost, largest first."""
        return tuple(sorted(self.cells, key=lambda cell: -cell.share)[:number])

    def share_of_position(self, position: int) -> float:
        """Return the share of the cost of one position."""
        return sum(cell.share for cell in self.cells if cell.position == position)

    def share_of_element(self, output: str, input_name: str) -> float:
        """Return the share of the cost of one element over all positions."""
        return sum(cell.share for cell in self.cells if (cell.output, cell.input) == (output, input_name))


def residual_report(problem: GrayBoxProblem, fit: GrayBoxFit, bands: Sequence[float] | int = BANDS) -> ResidualReport:
    """Compare a fitted model with the measured responses.

    Args:
        problem: What was fitted.
        fit: Where the fit ended.
        bands: Edges between the frequency bands [Hz], or the number of bands of equally many lines.

    Returns:
        The report.
    """
    measured, weights = problem.measured, problem.weights
    response = problem.model_at(fit.values).response(fit.values)
    used = weights > 0
    error = problem.estimator.error(np.where(used, measured, 1.0), np.where(used, response, 1.0))
    cost = weights * np.abs(error) ** 2
    misfit = _misfit(problem, response)
    correction = _correction(problem, fit, int(np.count_nonzero(used)))
    total = max(float(np.sum(cost)), np.finfo(float).tiny)
    names = problem.responses[0]
    cells = []
    for lines in _lines_of_bands(problem.frequency, bands):
        for place, row, column in np.ndindex(len(measured), *measured.shape[2:]):
            here = (place, lines, row, column)
            if np.any(used[here]):
                numbers = _figures(cost[here], misfit[here], np.abs(response[here] / measured[here] - 1.0), used[here])
                cells.append(
                    ResidualCell(
                        position=place,
                        output=names.output_names[row],
                        input=names.input_names[column],
                        lowest=float(problem.frequency[lines[0]]),
                        highest=float(problem.frequency[lines[-1]]),
                        share=numbers.cost / total,
                        chi_square=numbers.chi_square * correction,
                        largest=numbers.largest,
                        at=float(problem.frequency[lines[numbers.place]]),
                        error=numbers.error,
                    )
                )
    overall = float(np.mean(misfit[used] ** 2)) * correction
    return ResidualReport(tuple(cells), response, float(np.sum(cost)), overall)


@dataclass(frozen=True)
class _Figures:
    cost: float
    chi_square: float
    largest: float
    place: int
    error: float


def _figures(cost: FloatArray, misfit: FloatArray, error: FloatArray, used: BoolArray) -> _Figures:
    """Sum up the lines of one cell that count."""
    known = bool(np.all(np.isfinite(misfit[used])))
    ranked = np.where(used, misfit if known else cost, -1.0)
    return _Figures(
        cost=float(np.sum(cost)),
        chi_square=float(np.mean(misfit[used] ** 2)),
        largest=float(np.max(misfit[used])),
        place=int(np.argmax(ranked)),
        error=float(np.max(error[used])),
    )


def _misfit(problem: GrayBoxProblem, response: ComplexArray) -> FloatArray:
    """Misfit of every element in standard deviations of |G - G_0|, NaN where those are not known, (Q, F, M, M)."""
    rows = []
    for given, model in zip(problem.responses, response, strict=True):
        noise = response_noise(given)
        variance = np.full(model.shape, np.nan) if noise is None else noise.variance
        rows.append(np.abs(given.response - model) / np.sqrt(np.where(variance > 0, variance, np.nan)))
    return np.stack(rows)


def _correction(problem: GrayBoxProblem, fit: GrayBoxFit, count: int) -> float:
    """Elements over degrees of freedom, each real parameter taking half of a complex element."""
    free = len(fit.names) - int(np.count_nonzero(fit.at_bound))
    return count / max(count - 0.5 * free, 1.0)


def _lines_of_bands(frequency: FloatArray, bands: Sequence[float] | int) -> list[IntArray]:
    """Divide the lines among the bands; bands without lines are left out."""
    if isinstance(bands, int):
        parts = np.array_split(np.arange(len(frequency)), bands)
    else:
        parts = np.split(np.arange(len(frequency)), np.searchsorted(frequency, np.sort(bands)))
    return [part for part in parts if len(part)]
