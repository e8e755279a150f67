"""Section: the parameters with intervals and verdicts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import plotly.graph_objects as go

from flexros.identify.report.verdict import covariance_text, kept_text
from flexros.identify.report.words import (
    VERDICT_COLOURS,
    VERDICT_WORDS,
    interval_text,
    rounded_text,
    true_text,
    value_text,
)
from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.number_text import percent
from flexros.report.theme import INK, MUTED, stacked

if TYPE_CHECKING:
    from flexros.identify.graybox.identifiability import ParameterVerdict
    from flexros.identify.result import IdentificationResult

_FAR = 100.0
"""Intervals are drawn up to this factor from the nominal value (chosen)."""

_NARROW, _FEW_DECADES = 0.35, 1.6
_MARKS = (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0)
"""Marks of an axis between `_NARROW` and `_FEW_DECADES` decades (chosen)."""
_BIAS = (
    "The model has a form error: the robot shows effects that it does not contain. They bias the estimates, those of "
    "dampers most. The intervals cover random errors, not this bias: errors may exceed them. Signs of it: "
)


class ParameterSection(AbstractSection["IdentificationResult"]):
    """Nominal and identified values, 95 % intervals, verdicts; where the truth is known, it too."""

    title: ClassVar[str] = "Parameters"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return picture, table and what the intervals rest on."""
        blocks: list[Block] = []
        if np.all(result.nominal > 0):
            blocks.append(_picture(result))
        blocks += [_table(result), Paragraph(covariance_text(result), "note")]
        if kept := kept_text(result):
            blocks.append(Paragraph(kept, "warning"))
        if result.bias_signs:
            blocks.append(Paragraph(f"{_BIAS}{'; '.join(result.bias_signs)}.", "warning"))
        return tuple(blocks)


def _picture(result: IdentificationResult) -> Picture:
    """Draw identified over nominal values with their intervals, one row per parameter."""
    groups = _groups(result)
    rows = max(len(members) for _, members in groups)
    titles = [f"{title}: identified over nominal value" for title, _ in groups]
    figure = stacked(titles, columns=len(groups), height=60 + 24 * rows, shared_x=False)
    for column, (_, members) in enumerate(groups, start=1):
        _draw(figure, result, members, column)
        figure.update_yaxes(autorange="reversed", showgrid=False, tickfont={"size": 11}, row=1, col=column)
        figure.update_xaxes(type="log", **_ticks(result, members), row=1, col=column)
        figure.add_vline(x=1.0, line={"color": MUTED, "width": 1, "dash": "dot"}, row=1, col=column)
    _widen(figure, len(groups))
    caption = "Identified over nominal value of each parameter with its 95 % interval"
    known = "; diamonds: the true values of the simulated robot" if result.truth else ""
    return Picture(figure, f"{caption}{known}. Hover for figures.")


def _ticks(result: IdentificationResult, members: list[int]) -> dict[str, Any]:
    """Choose marks that are read at a glance for the range that is drawn."""
    entries = [result.identifiability.parameters[index] for index in members]
    ends = np.array([(*entry.interval, entry.value, result.truth.get(entry.name, entry.value)) for entry in entries])
    drawn = np.clip(ends / result.nominal[members][:, None], 1 / _FAR, _FAR)
    decades = np.log10(np.max(drawn) / np.min(drawn))
    if decades > _FEW_DECADES:
        return {"dtick": 1, "minor": {"ticks": "outside"}}
    return {"tickvals": _MARKS} if decades > _NARROW else {}


def _widen(figure: go.Figure, columns: int) -> None:
    """Return the names of parameters room at the left of each panel."""
    figure.update_layout(margin={"l": 170})
    if columns == 2:
        figure.update_layout(xaxis={"domain": [0.0, 0.4]}, xaxis2={"domain": [0.6, 1.0]})
        for note, axis in zip(figure.layout.annotations, (figure.layout.xaxis, figure.layout.xaxis2), strict=False):
            note.x = axis.domain[0]


def _draw(figure: go.Figure, result: IdentificationResult, members: list[int], column: int) -> None:
    for kind, colour in VERDICT_COLOURS.items():
        chosen = [index for index in members if result.identifiability.parameters[index].verdict == kind]
        if column == 1 or chosen:
            figure.add_trace(_dots(result, chosen, kind, colour, column == 1), row=1, col=column)
    true = [index for index in members if result.fit.names[index] in result.truth]
    if true:
        ratio = [result.truth[result.fit.names[index]] / result.nominal[index] for index in true]
        figure.add_trace(
            go.Scatter(
                x=ratio,
                y=[_label(result.fit.names[index]) for index in true],
                mode="markers",
                name="true value",
                legendgroup="true value",
                showlegend=column == 1,
                marker={"symbol": "diamond-open", "size": 10, "color": INK},
                hovertemplate="%{y}: %{x:.4g}<extra>true value</extra>",
            ),
            row=1,
            col=column,
        )


def _dots(result: IdentificationResult, chosen: list[int], kind: str, colour: str, legend: bool) -> go.Scatter:
    entries = [result.identifiability.parameters[index] for index in chosen]
    nominal = result.nominal[chosen]
    ratio = np.array([entry.value for entry in entries]) / nominal
    low, high = (
        np.clip(np.array([entry.interval[end] for entry in entries]) / nominal, 1 / _FAR, _FAR) for end in (0, 1)
    )
    return go.Scatter(
        x=ratio,
        y=[_label(entry.name) for entry in entries],
        error_x={
            "type": "data",
            "symmetric": False,
            "array": np.maximum(high - ratio, 0),
            "arrayminus": np.maximum(ratio - low, 0),
            "color": colour,
            "thickness": 2,
            "width": 4,
        },
        mode="markers",
        name=VERDICT_WORDS[kind],
        legendgroup=kind,
        showlegend=legend,
        marker={"color": colour, "size": 7},
        customdata=[[percent(entry.relative)] for entry in entries],
        hovertemplate="%{y}: %{x:.4g}, standard deviation %{customdata[0]} %<extra></extra>",
    )


def _groups(result: IdentificationResult) -> list[tuple[str, list[int]]]:
    """Split the parameters into springs and the others."""
    names = result.fit.names
    springs = [index for index, name in enumerate(names) if name.endswith(".stiffness")]
    others = [index for index, name in enumerate(names) if not name.endswith(".stiffness")]
    dampers = all(names[index].endswith(".damping") for index in others)
    groups = [("Springs", springs), ("Dampers" if dampers else "Other parameters", others)]
    return [(title, members) for title, members in groups if members]


def _label(name: str) -> str:
    return name.removesuffix(".stiffness").removesuffix(".damping")


def _table(result: IdentificationResult) -> TextTable:
    known = bool(result.truth)
    header = ("Parameter", "Unit", "nominal", "identified", "95 % interval", "std [%]", "verdict")
    rows = []
    for index, entry in enumerate(result.identifiability.parameters):
        row = parameter_row(entry, float(result.nominal[index]), result.truth.get(entry.name))
        rows.append(row if known else row[:-1])
    caption = "Nominal and identified values; standard deviations relative to the value."
    return TextTable((*header, "true") if known else header, tuple(rows), caption, left=2)


def parameter_row(entry: ParameterVerdict, nominal: float, true: float | None = None) -> tuple[str, ...]:
    """Write a parameter as the texts of a row: name, unit, nominal, identified, interval, deviation, verdict, truth.

    Args:
        entry: Value, interval and verdict.
        nominal: Its value before (SI).
        true: Its true value (SI), where it is known.

    Returns:
        The texts.
    """
    low, high = entry.interval
    return (
        entry.name,
        entry.unit,
        value_text(nominal),
        rounded_text(entry.value, low, high),
        interval_text(low, entry.value, high),
        percent(entry.relative, 2),
        VERDICT_WORDS[entry.verdict],
        "-" if true is None else true_text(true, low, high),
    )
