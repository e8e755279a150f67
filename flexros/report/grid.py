"""Pictures of many small panels over frequency, with a menu of positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from plotly.subplots import make_subplots

from flexros.report.theme import MUTED, dress

if TYPE_CHECKING:
    from collections.abc import Sequence

    import plotly.graph_objects as go

    from flexros.arrays import FloatArray

_TOP, _BOTTOM = 108, 56
"""Margins [px]: menu, legend and titles above; labels of the last axis below."""


def panels(rows: int, columns: int, titles: Sequence[str], height: int, gap: int = 30) -> go.Figure:
    """Create an empty picture of small panels with common axes, in the style of the report.

    Args:
        rows: Number of rows.
        columns: Number of columns.
        titles: Title of each panel, row by row.
        height: Height of one row [px].
        gap: Space between rows, for titles [px].

    Returns:
        The picture; x is a logarithmic frequency.
    """
    total = _TOP + _BOTTOM + height * rows
    figure = make_subplots(
        rows=rows,
        cols=columns,
        shared_xaxes="all",
        shared_yaxes="all",
        vertical_spacing=gap / (height * rows) if rows > 1 else 0.0,
        horizontal_spacing=0.012 if columns > 1 else 0.0,
        subplot_titles=list(titles),
    )
    dress(figure, total, (64, 12, _TOP, _BOTTOM), 12, 1 + 30 / (height * rows))
    for axes in (figure.update_xaxes, figure.update_yaxes):
        axes(mirror=True, ticklen=3, tickfont={"size": 11}, title_standoff=4)
    figure.update_xaxes(type="log", tickvals=[0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000])
    figure.update_annotations(font={"size": 11, "color": MUTED})
    return figure


def menu(buttons: Sequence[dict[str, Any]], x: float = 0.0, width_ahead: int = 0) -> dict[str, Any]:
    """Create a drop-down menu above the panels.

    Args:
        buttons: Its entries, as plotly takes them.
        x: Position along the picture, 0 to 1.
        width_ahead: Space before it [px].

    Returns:
        The menu for `layout.updatemenus`.
    """
    return {
        "type": "dropdown",
        "buttons": list(buttons),
        "x": x,
        "xanchor": "left",
        "y": 1.0,
        "yanchor": "bottom",
        "pad": {"b": _TOP - 42, "l": width_ahead},
        "bgcolor": "#ffffff",
        "bordercolor": "#8b949e",
        "font": {"size": 12},
        "showactive": True,
    }


def digits(values: FloatArray, significant: int = 4) -> list[float | None]:
    """Round to significant digits so that the page stays small; values that are not finite become None.

    Args:
        values: Values, shape (n,).
        significant: Number of digits.
    """
    return [float(f"{value:.{significant - 1}e}") if np.isfinite(value) else None for value in values]
