"""Section: what the experiment took, and what the choice of its positions gained."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
import plotly.graph_objects as go

from flexros.identify.design.experiment_design import SLOW
from flexros.identify.report.words import counted
from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.number_text import number
from flexros.report.theme import INK, run_colour, stacked

if TYPE_CHECKING:
    from flexros.identify.design.experiment_design import ExperimentDesign
    from flexros.identify.result import ExperimentFacts, IdentificationResult


class ExperimentSection(AbstractSection["IdentificationResult"]):
    """Robot time, blocks, periods; positions; gain of the design against random positions."""

    title: ClassVar[str] = "Experiment"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return facts, gain and positions."""
        blocks: list[Block] = []
        if result.facts is not None:
            blocks.append(Paragraph(_facts(result.facts)))
        if result.design is not None:
            blocks += [Paragraph(_gain(result.design)), _picture(result.design)]
        return (*blocks, _positions(result))


def _facts(facts: ExperimentFacts) -> str:
    text = (
        f"{number(facts.robot_time / 60, 3)} minutes of robot time: {counted(facts.positions, 'position')}, "
        f"{counted(facts.blocks, 'block')}, {counted(facts.experiments, 'experiment')} ({facts.excitation}) with "
        f"{counted(facts.periods, 'recorded period')} of {number(facts.period)} s each"
    )
    text += f"; transport: {facts.transport}" if facts.transport else ""
    return f"{text}. Log: {facts.log}." if facts.log else f"{text}."


def _gain(design: ExperimentDesign) -> str:
    gain, chosen, support = design.gain, len(design.chosen), len(design.design.support)
    others = ((why, count) for why, count in design.candidates.refused.items() if why != SLOW)
    refused = "; ".join(f"{count} more were refused because {why}" for why, count in others)
    return (
        f"The positions were chosen out of {design.origin}, such that the determinant of the "
        f"information is largest (optimal shares over {support} position{'s' * (support != 1)}, duality gap "
        f"{design.design.gap:.1g}{'; ' * bool(refused)}{refused}). {chosen} whole positions keep "
        f"{100 * gain.efficiency:.3g} % of the optimum; sets of as many random positions have "
        f"{100 * float(np.median(gain.random_efficiency)):.3g} % in the median and "
        f"{100 * float(gain.random_efficiency[-1]):.3g} % at best, so they would need "
        f"{number(gain.experiments_saved, 2)} times the experiments.{' ' * bool(design.remark)}{design.remark}"
    )


def _picture(design: ExperimentDesign) -> Picture:
    """Draw the predicted deviation of each parameter and that of random positions."""
    gain = design.gain
    figure = stacked(["Smallest possible standard deviation of each parameter"], height=300)
    kinds = (("chosen positions", gain.deviation, run_colour(0)), ("random positions", gain.random_deviation, INK))
    for name, values, colour in kinds:
        figure.add_trace(
            go.Scatter(
                x=list(design.names),
                y=100 * np.where(np.isfinite(values), values, np.nan),
                mode="markers",
                name=name,
                marker={
                    "color": colour,
                    "size": 8,
                    "symbol": "circle" if name.startswith("chosen") else "line-ew-open",
                },
                hovertemplate=f"%{{x}}: %{{y:.3g}} %<extra>{name}</extra>",
            )
        )
    figure.update_yaxes(
        type="log", title_text="relative [%]", dtick=1, exponentformat="none", minor={"ticks": "outside"}
    )
    figure.update_xaxes(tickangle=-60, tickfont={"size": 10})
    figure.update_layout(margin={"b": 150}, height=figure.layout.height + 100)
    caption = (
        "Smallest deviations that any fit could reach, predicted by the nominal model for encoder noise"
        f"{_distorted(design)}: chosen positions, and the median of random sets of as many positions. Weights other "
        "than optimal ones give larger ones, as in the table of parameters."
    )
    return Picture(figure, caption)


def _distorted(design: ExperimentDesign) -> str:
    share = design.conditions.distortion
    return f" and distortions of {number(100 * share, 2)} % of the output" if share else " alone"


def _positions(result: IdentificationResult) -> TextTable:
    responses = result.problem.responses
    names = responses[0].output_names
    rows = tuple(
        (
            str(index + 1),
            *(number(float(value) + 0.0, 4) for value in response.gears),
            str(response.n_blocks),
            str(response.n_periods),
        )
        for index, response in enumerate(responses)
    )
    units = responses[0].coordinate_units
    header = ("Position", *(f"{name} [{unit}]" for name, unit in zip(names, units, strict=True)), "blocks", "periods")
    return TextTable(header, rows, "Gear coordinates of the positions, and what was recorded in each.")
