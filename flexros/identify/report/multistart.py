"""Section: where the search from many starts ended (Paper A, figures 3 and 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
import plotly.graph_objects as go

from flexros.report.base import AbstractSection, Block, Paragraph, Picture
from flexros.report.number_text import number
from flexros.report.theme import LOGARITHMIC, run_colour, stacked

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.result import IdentificationResult


class StartSection(AbstractSection["IdentificationResult"]):
    """Cost of the fit from each start, sorted."""

    title: ClassVar[str] = "Local minima"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return the sentence, and the picture where the fits differ; nothing for a single start."""
        costs = result.start_costs
        if len(result.searched) < 2 or not len(costs):
            return ()
        fit = result.searched[0]
        text = (
            f"{result.same_minimum} of {len(result.searched)} fits ({fit.estimator}, {fit.weights} weights) ended "
            "in the best minimum"
        )
        if result.same_minimum < len(costs):
            text += f"; the others cost up to {number(float(costs[-1] / costs[0]), 3)} times as much"
        failed = len(result.searched) - len(costs)
        if failed:
            text += f"; {failed} failed, because the model cannot be evaluated at their starts"
        text += (
            ". No minimum was found twice, so a better one may exist: use more initial values."
            if result.same_minimum == 1
            else "."
        )
        differ = result.same_minimum < len(costs)
        return (Paragraph(text), _picture(costs)) if differ else (Paragraph(text),)


def _picture(costs: FloatArray) -> Picture:
    """Draw the costs over the lowest one."""
    figure = stacked(["Cost from each start over the lowest, sorted"], height=240)
    figure.add_trace(
        go.Scatter(
            x=np.arange(1, len(costs) + 1),
            y=costs / costs[0],
            mode="markers",
            marker={"color": run_colour(0), "size": 7},
            hovertemplate="%{x}: %{y:.4g}<extra></extra>",
            showlegend=False,
        )
    )
    figure.update_yaxes(title_text="cost / lowest cost", **LOGARITHMIC)
    figure.update_xaxes(title_text="start", range=[0.5, len(costs) + 0.5], tickformat="d")
    return Picture(figure, "Costs of the fits from all starts; those at 1 ended in the best minimum.")
