"""Section: locations of the gap, computed without any hypothesis."""

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
"""p-value below which a location is significant."""
_MOST_ROWS = 8
"""Rows of the table (chosen)."""
_SCALE = [[0, "#ffffff"], [0.15, "#cfe2f0"], [1, "#0072b2"]]


class WhereSection(AbstractSection["DiagnosisResult"]):
    """Heat maps of the excess by joint and band, and by joint and regime; a table of the locations."""

    title: ClassVar[str] = "Where it shows"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return sentence, maps and table."""
        mapped = result.excess or result.diagnosis.where
        if not mapped:
            return ()
        bands = [location for location in mapped if location.regime == "all"]
        regimes = [location for location in mapped if location.regime != "all"]
        maps: list[Block] = []
        if len(bands) > 1:
            ordered = sorted(bands, key=lambda location: location.band_hz)
            figure = _map(ordered, [_ends(location) for location in ordered], "frequency band [Hz]")
            maps.append(Picture(figure, _caption("frequency band")))
        if len(regimes) > 1:
            figure = _map(
                regimes, [_wrapped(location.regime.replace("_", " "), 13) for location in regimes], "part of the motion"
            )
            maps.append(Picture(figure, _caption("part of the motion")))
        return (Paragraph(_sentence(mapped)), *maps, _table(mapped, 0.5 / result.record.sample_time))


def _sentence(mapped: Sequence[Excess]) -> str:
    significant = [location for location in mapped if location.p_value < SIGNIFICANT]
    text = (
        "Without any assumption on the effect, the power of the prediction errors above noise is divided by joint, "
        f"frequency band and part of the motion. Of {len(mapped)} locations {len(significant)} are significant at "
        f"{100 * SIGNIFICANT:.0f} %; the p-values account for the number of locations tested."
    )
    return text if significant else f"{text} There is no sign of a gap."


def _caption(label: str) -> str:
    return (
        f"Share of the excess by joint and {label}. A dot marks significant locations (p < {SIGNIFICANT:g} over all "
        "locations tested)."
    )


def _ends(location: Excess) -> str:
    """Write the ends of a band briefly."""
    low, high = (number(end, 2 if end < 100 else 3) for end in location.band_hz)
    return f"<{high}" if location.band_hz[0] <= 0 else f"{low}-{high}"


def _wrapped(text: str, width: int) -> str:
    """Break a text into lines of a picture."""
    return "<br>".join(textwrap.wrap(text, width))


def _map(locations: Sequence[Excess], labels: Sequence[str], title: str) -> go.Figure:
    import plotly.graph_objects as go

    from flexros.report.grid import digits
    from flexros.report.theme import stacked

    rows = list(dict.fromkeys(_wrapped(_row(location), 22) for location in locations))
    columns = list(dict.fromkeys(labels))
    share, p_value = np.full((2, len(rows), len(columns)), np.nan)
    for location, label in zip(locations, labels, strict=True):
        cell = rows.index(_wrapped(_row(location), 22)), columns.index(label)
        share[cell], p_value[cell] = 100 * location.share, location.p_value
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
    # All at once: each call of add_annotation() checks those of before again.
    figure.update_layout(annotations=_cell_texts(rows, columns, share, p_value))
    figure.update_yaxes(autorange="reversed", showgrid=False)
    figure.update_xaxes(title_text=title, showgrid=False, type="category", automargin=True, tickfont={"size": 11})
    lines = 1 + max(label.count("<br>") for label in columns)
    figure.update_layout(margin={"l": 170, "t": 20, "b": 44 + 14 * lines}, height=64 + 44 * len(rows) + 14 * lines)
    return figure


def _cell_texts(
    rows: Sequence[str], columns: Sequence[str], share: FloatArray, p_value: FloatArray
) -> list[dict[str, object]]:
    """Annotations with share and significance, one per cell."""
    dark_from = 0.55 * max(float(np.nanmax(share)), 1.0)
    return [
        {
            "x": columns[c],
            "y": rows[r],
            "text": f"{share[r, c]:.0f}" + ("<br>●" if p_value[r, c] < SIGNIFICANT else ""),
            "showarrow": False,
            "font": {"size": 11, "color": "#ffffff" if share[r, c] > dark_from else "#1b1f24"},
        }
        for r, c in np.argwhere(np.isfinite(share))
    ]


def _row(location: Excess) -> str:
    return location.signal if location.joint == "tool" else f"{location.joint} {location.signal}"


def _table(mapped: Sequence[Excess], highest: float) -> TextTable:
    ordered = sorted(mapped, key=lambda location: (location.p_value >= SIGNIFICANT, -location.share))
    rows = tuple(
        (
            _row(location),
            band_words(location.band_hz, highest),
            location.regime.replace("_", " "),
            share_words(location.share),
            p_value_words(location.p_value).removeprefix("p ").removeprefix("= "),
        )
        for location in ordered[:_MOST_ROWS]
    )
    header = ("Signal", "band", "part of the motion", "share of the excess", "p-value")
    return TextTable(header, rows, "The largest locations, significant ones first.", left=3)
