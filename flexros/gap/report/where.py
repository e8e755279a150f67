"""Section: where the gap shows, found without any hypothesis."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.report.words import band_words, p_value_words, share_words
from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    import plotly.graph_objects as go

    from flexros.arrays import FloatArray
    from flexros.gap.result import DiagnosisResult
    from flexros.gap.schema import Excess

SIGNIFICANT = 0.05
"""p-value below which a place counts as one of the gap."""
_MOST_ROWS = 8
"""Rows of the table (chosen)."""
_SCALE = [[0, "#ffffff"], [0.15, "#cfe2f0"], [1, "#0072b2"]]


class WhereSection(AbstractSection["DiagnosisResult"]):
    """Heat maps of the excess by joint and band, and by joint and regime; the places as a table."""

    title: ClassVar[str] = "Where it shows"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return sentence, maps and table."""
        looked = result.excess or result.diagnosis.where
        if not looked:
            return ()
        bands = [place for place in looked if place.regime == "all"]
        regimes = [place for place in looked if place.regime != "all"]
        maps: list[Block] = []
        if len(bands) > 1:
            ordered = sorted(bands, key=lambda place: place.band_hz)
            figure = _map(ordered, [_ends(place) for place in ordered], "frequency band [Hz]")
            maps.append(Picture(figure, _caption("frequency band")))
        if len(regimes) > 1:
            figure = _map(
                regimes, [_wrapped(place.regime.replace("_", " "), 13) for place in regimes], "part of the motion"
            )
            maps.append(Picture(figure, _caption("part of the motion")))
        return (Paragraph(_sentence(looked)), *maps, _table(looked, 0.5 / result.record.sample_time))


def _sentence(looked: Sequence[Excess]) -> str:
    found = [place for place in looked if place.p_value < SIGNIFICANT]
    text = (
        "Before any effect is assumed, the part of the prediction error that exceeds noise is split by joint, "
        f"frequency band and part of the motion. Of {len(looked)} places {len(found)} exceed what chance allows at "
        f"{100 * SIGNIFICANT:.0f} %; the p-values already account for so many looks."
    )
    return text if found else f"{text} Nothing here is a gap."


def _caption(label: str) -> str:
    return (
        f"Share of the excess by joint and {label}. A dot marks what chance does not explain (p < {SIGNIFICANT:g} over "
        "all places looked at)."
    )


def _ends(place: Excess) -> str:
    """Write the ends of a band in little room."""
    low, high = (number(end, 2 if end < 100 else 3) for end in place.band_hz)
    return f"<{high}" if place.band_hz[0] <= 0 else f"{low}-{high}"


def _wrapped(text: str, width: int) -> str:
    """Break a text into lines of a picture."""
    return "<br>".join(textwrap.wrap(text, width))


def _map(places: Sequence[Excess], labels: Sequence[str], title: str) -> go.Figure:
    import plotly.graph_objects as go

    from flexros.report.grid import digits
    from flexros.report.theme import stacked

    rows = list(dict.fromkeys(_wrapped(_row(place), 22) for place in places))
    columns = list(dict.fromkeys(labels))
    share, p_value = np.full((2, len(rows), len(columns)), np.nan)
    for place, label in zip(places, labels, strict=True):
        cell = rows.index(_wrapped(_row(place), 22)), columns.index(label)
        share[cell], p_value[cell] = 100 * place.share, place.p_value
    figure = stacked([""])
    figure.add_trace(
        go.Heatmap(
            z=[digits(row) for row in share],
            customdata=[digits(row) for row in p_value],
            x=columns,
            y=rows,
            zmin=0,
            zmax=max(float(np.nanmax(share)), 1.0),
            colorscale=_SCALE,
            showscale=False,
            xgap=2,
            ygap=2,
            hovertemplate="%{y}, %{x}: %{z:.3g} % of the excess, p = %{customdata:.2g}<extra></extra>",
        )
    )
    _write_cells(figure, rows, columns, share, p_value)
    figure.update_yaxes(autorange="reversed", showgrid=False)
    figure.update_xaxes(title_text=title, showgrid=False, type="category", tickangle=0, tickfont={"size": 11})
    lines = 1 + max(label.count("<br>") for label in columns)
    figure.update_layout(margin={"l": 170, "t": 20, "b": 44 + 14 * lines}, height=64 + 44 * len(rows) + 14 * lines)
    return figure


def _write_cells(
    figure: go.Figure, rows: Sequence[str], columns: Sequence[str], share: FloatArray, p_value: FloatArray
) -> None:
    """Write share and significance into the cells."""
    largest = float(np.nanmax(share))
    for r, row in enumerate(rows):
        for c, column in enumerate(columns):
            if np.isfinite(share[r, c]):
                dot = " ●" if p_value[r, c] < SIGNIFICANT else ""
                dark = share[r, c] > 0.55 * max(largest, 1.0)
                figure.add_annotation(
                    x=column,
                    y=row,
                    text=f"{share[r, c]:.0f}{dot}",
                    showarrow=False,
                    font={"size": 12, "color": "#ffffff" if dark else "#1b1f24"},
                )


def _row(place: Excess) -> str:
    return place.joint if place.joint == "tool" else f"{place.joint} {place.signal}"


def _table(looked: Sequence[Excess], highest: float) -> TextTable:
    ordered = sorted(looked, key=lambda place: (place.p_value >= SIGNIFICANT, -place.share))
    rows = tuple(
        (
            _row(place),
            band_words(place.band_hz, highest),
            place.regime.replace("_", " "),
            share_words(place.share),
            p_value_words(place.p_value).removeprefix("p ").removeprefix("= "),
        )
        for place in ordered[:_MOST_ROWS]
    )
    header = ("Signal", "band", "part of the motion", "share of the excess", "p-value")
    return TextTable(header, rows, "The largest places, those that chance does not explain first.", left=3)
