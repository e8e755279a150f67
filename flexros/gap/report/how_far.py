"""Section: the gap between robot and model before and after the repair, on data that was not fitted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar

from flexros.gap.report.figure_words import gap_closed_words, gap_words, interval_words, shows
from flexros.gap.report.innovations import innovation_picture
from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.colours import FLOOR, NOMINAL, REPAIRED, RIVAL
from flexros.report.number_text import number

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from flexros.gap.result import DiagnosisResult, SignalGap
    from flexros.gap.schema import GapNumbers


class HowFarSection(AbstractSection["DiagnosisResult"]):
    """Bars of the gap, the gap by signal, and the prediction errors over time."""

    title: ClassVar[str] = "How far apart, before and after"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return sentence, bars, table and curves."""
        gap = result.diagnosis.gap
        blocks: list[Block] = [Paragraph(_sentence(gap)), Picture(gap_figure(gap), _caption(gap))]
        if result.signals:
            blocks.append(_table(result.signals))
        return (*blocks, innovation_picture(result))


def _sentence(gap: GapNumbers) -> str:
    text = f"The gap is the {gap.metric}; 'floor' is its value without any gap."
    if gap.tolerance_floor is not None:
        text += (
            " 'Floor with tolerance' is its value where torques are off by their stated tolerance all the time, not "
            "from sample to sample: an explanation may leave twice that."
        )
    if gap.after is not None and (gap.closed_fraction is None or not shows(gap)):
        return f"{text} The gap before is within its sampling error of the floor, so no closed share is stated."
    if gap.closed_fraction is None:
        return text
    within = interval_words(gap.interval).replace("(", "(95 % interval ")
    return f"{text} The repaired model closes {gap_closed_words(gap)} of it{within}."


def _caption(gap: GapNumbers) -> str:
    rival = " The best rival is the best explanation that was not chosen." if gap.best_rival is not None else ""
    return f"Gap on held-out data, logarithmic.{rival}"


def gap_figure(gap: GapNumbers) -> go.Figure:
    """Draw the gap before and after the repair, that of the best rival, and the noise floor."""
    import plotly.graph_objects as go

    from flexros.report.theme import LOGARITHMIC, stacked

    bars = [
        ("nominal model", gap.before, NOMINAL),
        ("best rival", gap.best_rival, RIVAL),
        ("repaired model", gap.after, REPAIRED),
        ("floor with tolerance", gap.tolerance_floor, FLOOR),
        ("floor", gap.noise_floor, FLOOR),
    ]
    shown = [(name, value, colour) for name, value, colour in bars if value is not None]
    figure = stacked([""], height=34 * len(shown) + 30)
    figure.add_trace(
        go.Bar(
            x=[value for _, value, _ in shown],
            y=[_label(name, value) for name, value, _ in shown],
            orientation="h",
            marker={"color": [colour for _, _, colour in shown]},
            hovertemplate="%{y}: %{x:.4g}<extra></extra>",
        )
    )
    whisker = _whisker(gap)
    if whisker is not None:
        figure.add_trace(whisker)
    smallest = min(value for _, value, _ in shown if value > 0)
    largest = max(value for _, value, _ in shown)
    figure.update_yaxes(autorange="reversed", showgrid=False)
    unit = "" if gap.unit == "1" else f" [{gap.unit}]"
    figure.update_xaxes(
        title_text=f"gap{unit}", range=[math.log10(0.5 * smallest), math.log10(2.2 * largest)], **LOGARITHMIC
    )
    figure.update_layout(margin={"l": 185, "t": 16}, showlegend=False, bargap=0.35)
    return figure


def _whisker(gap: GapNumbers) -> go.Scatter | None:
    """Return the interval of the gap that remains, from that of the closed fraction."""
    import plotly.graph_objects as go

    if gap.interval is None or gap.after is None or not shows(gap):
        return None
    span = gap.before - gap.noise_floor
    low, high = (max(gap.before - share * span, 1e-12) for share in (gap.interval[1], gap.interval[0]))
    return go.Scatter(
        x=[gap.after],
        y=[_label("repaired model", gap.after)],
        mode="markers",
        marker={"color": "#1b1f24", "size": 5},
        error_x={
            "type": "data",
            "symmetric": False,
            "array": [max(high - gap.after, 0.0)],
            "arrayminus": [max(gap.after - low, 0.0)],
            "thickness": 1.4,
            "width": 6,
        },
        hovertemplate=f"95 %: {low:.4g} to {high:.4g}<extra></extra>",
    )


def _label(name: str, value: float) -> str:
    return f"{name}: {gap_words(value)}"


def _table(signals: tuple[SignalGap, ...]) -> TextTable:
    rows = tuple(
        (
            signal.signal,
            signal.unit,
            number(signal.before, 3),
            number(signal.after, 3),
            number(signal.rival, 3),
            number(signal.floor, 3),
        )
        for signal in signals
    )
    header = ("Signal", "unit", "nominal model", "repaired model", "best rival", "floor")
    return TextTable(header, rows, "The gap in each signal, root mean square on held-out data.", left=2)
