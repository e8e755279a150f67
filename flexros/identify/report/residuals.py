"""Section: what the identified model leaves unexplained, and where."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
import plotly.graph_objects as go

from flexros.identify.report.verdict import advice
from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.number_text import number, percent
from flexros.report.theme import stacked

if TYPE_CHECKING:
    from flexros.identify.result import IdentificationResult

_WORST = 8
"""Rows of the table (chosen)."""


class ResidualSection(AbstractSection["IdentificationResult"]):
    """Shares of the cost by position and element, and the elements with the largest misfits."""

    title: ClassVar[str] = "What is left unexplained"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return the picture and the table."""
        hint = advice(result)
        return (Paragraph(_sentence(result)), *([Paragraph(hint)] if hint else []), _picture(result), _table(result))


def _sentence(result: IdentificationResult) -> str:
    chi = result.residuals.chi_square
    if not np.isfinite(chi):
        return "The responses have no covariance, so only its share of the cost is known of the misfit."
    reduced = result.covariance.reduced_cost
    text = (
        f"Squared misfit over the variance of the responses: {number(reduced, 3)} with the weights of the fit, "
        f"{number(chi, 3)} in the mean of all lines that count; about 1 is to be expected"
    )
    limits = result.limits
    few = f", and up to {number(limits.cost, 2)} and {number(limits.chi_square, 2)} comes by chance"
    if reduced < limits.cost and chi < limits.chi_square:
        return f"{text}{few}, so it is no sign of a systematic error."
    if result.settled:
        text += (
            f"{few}. What exceeds it is not noise: nonlinear effects, or flexibilities that the model does not have."
        )
    else:
        text += f"{few}. The fit ended on a bound or did not converge, so this is no evidence about the robot."
    return f"{text} The intervals were widened for it." if reduced > 1 else text


def _picture(result: IdentificationResult) -> Picture:
    responses = result.problem.responses
    outputs, inputs = responses[0].output_names, responses[0].input_names
    elements = [f"{inp} → {out}" for out in outputs for inp in inputs]
    shares = np.zeros((len(elements), len(responses)))
    for cell in result.residuals.cells:
        shares[elements.index(f"{cell.input} → {cell.output}"), cell.position] += cell.share
    figure = stacked(["Share of the cost by element and position"], height=max(120, 15 * len(elements) + 40))
    figure.add_trace(
        go.Heatmap(
            z=100 * shares,
            zmin=0,
            zmax=100 * float(shares.max()) or 1.0,  # without it zmin is not used
            x=[str(index + 1) for index in range(len(responses))],
            y=elements,
            colorscale=[[0, "#ffffff"], [1, "#0072b2"]],
            colorbar={"title": {"text": "%"}, "thickness": 12},
            xgap=1,
            ygap=1,
            hovertemplate="position %{x}, %{y}: %{z:.3g} %<extra></extra>",
        )
    )
    figure.update_yaxes(autorange="reversed", showgrid=False, tickfont={"size": 10}, dtick=1)
    figure.update_xaxes(title_text="position", showgrid=False, type="category", dtick=1)
    figure.update_layout(margin={"l": 140})
    return Picture(figure, "Where the cost of the fit comes from.")


def _table(result: IdentificationResult) -> TextTable:
    rows = []
    for cell in result.residuals.worst(_WORST):
        rows.append(
            (
                str(cell.position + 1),
                f"{cell.input} → {cell.output}",
                f"{number(cell.lowest, 3)} to {number(cell.highest, 3)}",
                percent(cell.share),
                number(cell.chi_square, 3),
                number(cell.largest, 3),
                number(cell.at, 4),
                percent(cell.error),
            )
        )
    header = (
        "Position",
        "Element",
        "band [Hz]",
        "share of cost [%]",
        "misfit² / variance",
        "largest [σ]",
        "at [Hz]",
        "largest error [%]",
    )
    caption = "The largest contributions to the cost; errors relative to the measured magnitude."
    return TextTable(header, tuple(rows), caption, left=2)
