"""Report of friction at constant speeds: figure 3.8 of Moberg (2007), with the fitted laws and their residuals."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import plotly.graph_objects as go

from flexros.report.base import Block, Paragraph, Picture, TextTable, Tiles
from flexros.report.number_text import number
from flexros.report.page import Chapter, page_html
from flexros.report.theme import INK, curve, run_colour, stacked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.identify.friction.laws import FrictionFit
    from flexros.identify.friction.measurement import FrictionMeasurement

_DRAWN = 1201
"""Points of a fitted law in the picture."""


def friction_report(measured: FrictionMeasurement, sources: Sequence[str]) -> str:
    """Make the report of a friction measurement.

    Args:
        measured: Points and fits.
        sources: Names of the logs.

    Returns:
        The HTML page, which opens offline.
    """
    count = len(measured.points.speed)
    chapters = [
        Chapter("", _summary(measured)),
        Chapter("Friction against speed", (Picture(friction_figure(measured), _caption(measured)),)),
        Chapter("Fitted laws", _laws(measured)),
        Chapter("Measured points", (_points(measured), Paragraph(f"Logs: {', '.join(sources)}.", "note"))),
    ]
    logs = f"{len(sources)} log{'s' * (len(sources) != 1)}"
    return page_html(f"Friction of {measured.joint}", f"{count} constant speeds from {logs}", chapters)


def friction_figure(measured: FrictionMeasurement) -> go.Figure:
    """Draw measured torques and fitted laws against the speed, and what the laws leave below.

    Args:
        measured: Points and fits.

    Returns:
        Two panels above each other, with one axis of speed.
    """
    figure = stacked([f"{measured.joint}: measured and fitted", "measured less fitted"], height=300)
    points, hover = measured.points, f"%{{x:.4g}} {measured.speed_unit}: %{{y:.4g}} {measured.torque_unit}"
    figure.add_trace(_marks(points.speed, points.torque, "measured", INK, hover, points.spread), row=1, col=1)
    speed = _speeds(points.speed)
    for index, fit in enumerate(measured.fits):
        name, colour = f"{fit.law.name} ({fit.law.equation})", run_colour(index)
        line = curve(speed, fit.law.evaluate(speed, fit.values), name, colour, hover=hover)
        figure.add_trace(line, row=1, col=1)
        left = points.torque - fit.law.evaluate(points.speed, fit.values)
        figure.add_trace(_marks(points.speed, left, name, colour, hover, legend=False), row=2, col=1)
    figure.update_yaxes(title_text=f"{'force' if measured.linear else 'torque'} [{measured.torque_unit}]")
    figure.update_xaxes(title_text=f"speed [{measured.speed_unit}]", row=2)
    return figure


def _marks(
    x: FloatArray,
    y: FloatArray,
    name: str,
    colour: str,
    hover: str,
    spread: FloatArray | None = None,
    *,
    legend: bool = True,
) -> go.Scatter:
    bars = {} if spread is None else {"error_y": {"array": spread, "color": "#c9ced6", "thickness": 1, "width": 3}}
    return go.Scatter(
        x=x,
        y=y,
        name=name,
        mode="markers",
        marker={"color": colour, "size": 7},
        hovertemplate=f"{hover}<extra>{name}</extra>",
        showlegend=legend,
        legendgroup=name,
        **bars,
    )


def _speeds(measured: FloatArray) -> FloatArray:
    """Return speeds for the lines: over the measured range, close together near standstill, with a step at zero."""
    sizes = np.geomspace(1e-4, 1.0, _DRAWN // 2)
    backward, forward = min(float(measured.min()), 0.0), max(float(measured.max()), 0.0)
    return np.concatenate((backward * sizes[::-1] if backward else [], forward * sizes if forward else []))


def _caption(measured: FrictionMeasurement) -> str:
    offset = measured.points.offset
    apart = f" without {number(offset)} {measured.torque_unit} that both directions share" if offset else ""
    return (
        f"Mean torque in each phase of constant speed{apart}; grey bars: standard deviation of the torque within the "
        "phase. Lines: the laws, fitted by least squares (as figure 3.8 of the thesis)."
    )


def _summary(measured: FrictionMeasurement) -> tuple[Block, ...]:
    best, size = measured.best, np.abs(measured.points.speed)
    tiles = [
        ("Constant speeds", str(size.size), "", "phases of at least 0.05 s"),
        ("Speeds", f"{number(float(size.min()), 3)} to {number(float(size.max()), 3)}", measured.speed_unit, "in size"),
    ]
    if best is None:
        text = "There are too few speeds for any law: measure more speeds than the law has parameters."
        return (Paragraph(text, "lead"), Tiles(tuple(tiles)))
    tiles.append(("Not explained", number(best.rms, 3), measured.torque_unit, f"rms, {best.law.name}"))
    text = (
        f'The law "{best.law.name}" (equation {best.law.equation}) explains the points best: '
        f"{_parameters(measured, best)}."
    )
    return (Paragraph(text, "lead"), Tiles(tuple(tiles)))


def _laws(measured: FrictionMeasurement) -> tuple[Block, ...]:
    header = ("Law", "equation", "parameters", f"rms [{measured.torque_unit}]", "information criterion")
    rows = tuple(
        (fit.law.name, fit.law.equation, _parameters(measured, fit), number(fit.rms, 3), f"{fit.criterion:.1f}")
        for fit in measured.fits
    )
    caption = (
        "Parameters with one standard deviation; of the laws whose parameters the speeds determine, the lowest "
        "criterion names the one that explains the points best. More speeds determine more."
    )
    return (TextTable(header, rows, caption, left=3),) if rows else ()


def _parameters(measured: FrictionMeasurement, fit: FrictionFit) -> str:
    texts = []
    for name, value, std in zip(fit.law.parameters, fit.values.tolist(), fit.deviations.tolist(), strict=True):
        unit = measured.unit(name)
        known = with_deviation(value, std) if np.isfinite(std) else f"{number(value, 3)} (not determined)"
        texts.append(f"{name} {known}{'' if unit == '1' else f' {unit}'}")
    return ", ".join(texts)


def with_deviation(value: float, deviation: float) -> str:
    """Write a value with its standard deviation, both to two digits of the deviation, e.g. "5.913 ± 0.069"."""
    places = max(0, 1 - math.floor(math.log10(deviation))) if deviation > 0.0 else 6
    return f"{round(value, places):.{places}f} ± {deviation:.{places}f}"


def _points(measured: FrictionMeasurement) -> TextTable:
    points, force = measured.points, measured.torque_unit
    header = (f"Speed [{measured.speed_unit}]", f"friction [{force}]", f"deviation within the phase [{force}]")
    rows = tuple(
        (number(float(points.speed[i])), number(float(points.torque[i])), number(float(points.spread[i]), 2))
        for i in np.argsort(points.speed)
    )
    return TextTable(header, rows, "Phases of constant speed.", left=0)
