"""Section: locations of the gap, computed without any hypothesis."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.report.figure_words import band_words, p_value_words, share_words
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
_BELOW = 0.6
"""Lower end of a band from 0 Hz as drawn, relative to the lowest upper end of all (chosen)."""
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
        realisations = result.simulated_logs
        maps: list[Block] = []
        if len(bands) > 1:
            ordered = sorted(bands, key=lambda location: location.band_hz)
            maps.append(Picture(_spectrum(ordered, realisations), _caption("frequency band, each as wide as its band")))
        if len(regimes) > 1:
            figure = _map(
                regimes, [_wrapped(location.regime.replace("_", " "), 13) for location in regimes], "part of the motion"
            )
            maps.append(Picture(figure, _caption("part of the motion")))
        return (Paragraph(_sentence(mapped)), *maps, _table(mapped, 0.5 / result.record.sample_time, realisations))


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


def _wrapped(text: str, width: int) -> str:
    """Break a text into lines of a picture."""
    return "<br>".join(textwrap.wrap(text, width))


def _spectrum(locations: Sequence[Excess], realisations: int) -> go.Figure:
    """Draw every band at its frequencies: those of several signals need not be the same."""
    import plotly.graph_objects as go

    from flexros.report.theme import LOGARITHMIC, stacked

    rows = list(dict.fromkeys(_row(location) for location in locations))
    lowest = _BELOW * min(location.band_hz[1] for location in locations)
    largest = max(100 * max(location.share for location in locations), 1.0)
    figure = stacked([""])
    texts: list[dict[str, object]] = []
    for location in locations:
        row, (low, high) = rows.index(_row(location)), location.band_hz
        low, share = max(low, lowest), 100 * location.share
        words = band_words(location.band_hz, math.inf)
        figure.add_trace(
            go.Heatmap(
                z=[[share]], x=[low, high], y=[row - 0.5, row + 0.5], zmin=0, zmax=largest, colorscale=_SCALE,
                showscale=False, xgap=2, ygap=2,
                hovertemplate=f"{_row(location)}, {words}: {number(share, 3)} % of the excess, "
                f"{p_value_words(location.p_value, realisations)}<extra></extra>",
            )
        )  # fmt: skip
        texts.append(_text(0.5 * math.log10(low * high), row, share, location.p_value, largest))
    figure.update_layout(annotations=texts)
    figure.update_yaxes(
        tickvals=list(range(len(rows))),  # names as categories would have to be the same in every trace
        ticktext=[_wrapped(row, 22) for row in rows],
        range=[len(rows) - 0.5, -0.5],
        showgrid=False,
    )
    ends = [math.log10(lowest), math.log10(max(location.band_hz[1] for location in locations))]
    figure.update_xaxes(title_text="frequency [Hz]", range=ends, showgrid=False, dtick="D2", **LOGARITHMIC)
    figure.update_layout(margin={"l": 170, "t": 20, "b": 58}, height=78 + 44 * len(rows))
    return figure


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
    largest = max(float(np.nanmax(share)), 1.0)
    return [_text(columns[c], rows[r], share[r, c], p_value[r, c], largest) for r, c in np.argwhere(np.isfinite(share))]


def _text(x: str | float, y: str | int, share: float, p_value: float, largest: float) -> dict[str, object]:
    """Return the annotation of one cell, white on dark blue."""
    return {
        "x": x,
        "y": y,
        "text": f"{share:.0f}" + ("<br>●" if p_value < SIGNIFICANT else ""),
        "showarrow": False,
        "font": {"size": 11, "color": "#ffffff" if share > 0.55 * largest else "#1b1f24"},
    }


def _row(location: Excess) -> str:
    return location.signal if location.joint == "tool" else f"{location.joint} {location.signal}"


def _table(mapped: Sequence[Excess], highest: float, realisations: int) -> TextTable:
    ordered = sorted(mapped, key=lambda location: (location.p_value >= SIGNIFICANT, -location.share))
    rows = tuple(
        (
            _row(location),
            band_words(location.band_hz, highest),
            location.regime.replace("_", " "),
            share_words(location.share),
            p_value_words(location.p_value, realisations).removeprefix("p ").removeprefix("= "),
        )
        for location in ordered[:_MOST_ROWS]
    )
    header = ("Signal", "band", "part of the motion", "share of the excess", "p-value")
    caption = "The largest locations, significant ones first."
    bound = next((row[-1] for row in rows if row[-1].startswith("≤")), "")
    if bound:
        caption += f" Where p is at most {bound[2:]}, none of {realisations} simulated logs without a gap has as much."
    return TextTable(header, rows, caption, left=3)
