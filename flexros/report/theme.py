"""Common appearance of the pictures of a report: colours, fonts, axes."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from flexros.report.decimate import screen_samples

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif'
INK = "#1b1f24"
MUTED = "#59636e"
GRID = "#e7eaee"
REFERENCE = "#59636e"
"""Colour of commanded signals; they are also dotted."""
LOGARITHMIC = {"type": "log", "tickformat": "~g"}
"""An axis in decades with whole numbers at its marks: without a format 20 and 50 would be written as 2 and 5."""
_RUNS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#5e3c99", "#8c510a")
"""Colours of runs, distinguishable for the colour-blind (Okabe and Ito 2008, extended)."""


_TOP, _BOTTOM = 64, 52
"""Margins [px]: legend and title of the first panel above; labels of the last axis and the tool bar below."""
_SCREEN, _LEAST_ROW = 500, 120
"""Height of all rows together on a laptop, its margins apart, and of one row at least [px] (chosen)."""


def run_colour(index: int) -> str:
    """Return the colour of the run with this index, from 0."""
    return _RUNS[index % len(_RUNS)]


def stacked(
    titles: Sequence[str], columns: int = 1, height: int = 230, shared_x: bool = True, gap: int = 60
) -> go.Figure:
    """Create an empty picture of panels in rows, top to bottom, in the style of the report.

    Args:
        titles: Title of each panel, row by row.
        columns: Number of panels side by side.
        height: Height of one row [px]; several rows are lower where they would not fit a laptop together.
        shared_x: Whether zooming along x in one panel zooms the others.
        gap: Space between rows, for the title of a panel and the labels of the axis above it [px].
    """
    rows = len(titles) // columns
    if rows > 1:
        height = min(height, max(_LEAST_ROW, _SCREEN // rows))
    total = _TOP + _BOTTOM + height * rows
    figure = make_subplots(
        rows=rows,
        cols=columns,
        shared_xaxes="all" if shared_x else False,
        vertical_spacing=0.0 if rows == 1 else min(gap / total, 0.9 / (rows - 1)),
        horizontal_spacing=0.09,
        subplot_titles=list(titles),
    )
    dress(figure, total, (72, 16, _TOP, _BOTTOM), 13, 1 + 26 / (height * rows))
    for index, note in enumerate(figure.layout.annotations):
        left = figure.layout[f"xaxis{index + 1 if index else ''}"].domain[0] if columns > 1 else 0
        note.update(font={"size": 13, "color": INK}, xanchor="left", x=left)
    return figure


def dress(figure: go.Figure, height: int, margins: tuple[int, int, int, int], font: int, legend: float) -> None:
    """Apply paper, fonts, legend and axes of the report to a picture.

    Args:
        figure: The picture.
        height: Its height [px].
        margins: Left, right, above and below the panels [px].
        font: Size of its texts [px].
        legend: Position of the legend, in heights of all panels from their lower end.
    """
    left, right, top, bottom = margins
    figure.update_layout(
        template=_style(font),
        height=height,
        margin={"l": left, "r": right, "t": top, "b": bottom},
        paper_bgcolor="#ffffff",
        plot_bgcolor="#ffffff",
        legend={"y": legend},
    )


@cache
def _style(font: int) -> go.layout.Template:
    """Return the style of all panels with texts of a size [px]."""
    axes = {
        "showgrid": True,
        "gridcolor": GRID,
        "zeroline": False,
        "linecolor": "#8b949e",
        "showline": True,
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": "#8b949e",
        "title": {"font": {"size": font, "color": MUTED}, "standoff": 8},
    }
    return go.layout.Template(
        layout={
            "font": {"family": FONT, "size": font, "color": INK},
            "legend": {"orientation": "h", "x": 0, "xanchor": "left", "yanchor": "bottom"},
            "hoverlabel": {"font": {"family": FONT, "size": 12}},
            "hovermode": "closest",
            "xaxis": axes,
            "yaxis": axes,
        }
    )


def space(height: int) -> go.Figure:
    """Create an empty picture of a scene in three dimensions, in the style of the report.

    Args:
        height: Its height [px].
    """
    figure = go.Figure()
    dress(figure, height, (8, 8, 36, 8), 12, 1.0)
    axis = {"gridcolor": GRID, "backgroundcolor": "#ffffff", "zerolinecolor": "#8b949e", "color": MUTED}
    axes = {f"{name}axis": {**axis, "title": {"text": f"{name} [m]"}} for name in "xyz"}
    figure.update_layout(scene={**axes, "aspectmode": "data", "camera": {"eye": {"x": 0.6, "y": -1.9, "z": 0.7}}})
    return figure


def curve(
    x: FloatArray,
    y: FloatArray,
    name: str,
    colour: str,
    *,
    hover: str,
    dash: str = "solid",
    legend: bool = True,
    group: str = "",
    width: float = 1.6,
) -> go.Scatter:
    """Create one line of a picture, reduced to screen resolution.

    Args:
        x: Abscissa, shape (n,).
        y: Ordinate, shape (n,).
        name: Name in the legend.
        colour: Colour of the line.
        hover: Text shown at the cursor, with %{x} and %{y}.
        dash: "solid" or "dot".
        legend: Whether it appears in the legend.
        group: Lines of one group are switched on and off together.
        width: Width [px].
    """
    shown = screen_samples(y)
    return go.Scatter(
        x=compact(x[shown]),
        y=compact(y[shown]),
        name=name,
        mode="lines",
        line={"color": colour, "width": width, "dash": dash},
        hovertemplate=f"{hover}<extra>{name}</extra>",
        showlegend=legend,
        legendgroup=group or name,
    )


def compact(values: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """Convert to single precision: seven digits exceed the resolution of a picture, at half the size."""
    largest = np.finfo(np.float32).max  # the values of a diverged run may be larger
    return np.asarray(np.clip(values, -largest, largest), dtype=np.float32)
