"""Small line pictures as SVG text, without any drawing library."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

WIDTH, HEIGHT = 380, 250
LEFT, RIGHT, TOP, BOTTOM = 52, 10, 24, 38
MOST_POINTS = 900
"""Points of a curve; a longer one is drawn by the smallest and largest value of equal pieces."""


@dataclass(frozen=True)
class Curve:
    """One line of a picture.

    Attributes:
        x: Values along, shape (n,).
        y: Values up, shape (n,).
        label: Text of the legend; empty: none.
        colour: Any SVG colour.
        width: Line width [px].
        dash: SVG dash pattern; empty: solid.
        marks: Whether dots are drawn instead of the line.
    """

    x: FloatArray
    y: FloatArray
    label: str = ""
    colour: str = "#1f5fa8"
    width: float = 1.2
    dash: str = ""
    marks: bool = False


@dataclass(frozen=True)
class Panel:
    """One pair of axes.

    Attributes:
        title: Text above.
        x_label: Text below, with unit.
        y_label: Text at the left, with unit.
        curves: What is drawn.
        x_ticks: Marks along; the first and last bound the axis.
        y_ticks: Marks up; the first and last bound the axis.
        logarithmic: Whether the x axis is.
    """

    title: str
    x_label: str
    y_label: str
    curves: Sequence[Curve]
    x_ticks: Sequence[float]
    y_ticks: Sequence[float]
    logarithmic: bool = True


def picture(panels: Sequence[Sequence[Panel]]) -> str:
    """Draw rows of panels.

    Args:
        panels: Panels by row and column.

    Returns:
        The SVG text.
    """
    columns = max(len(row) for row in panels)
    width, height = columns * WIDTH, len(panels) * HEIGHT
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'font-family="sans-serif" font-size="11" fill="#333">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    for i, row in enumerate(panels):
        for j, panel in enumerate(row):
            parts.append(f'<g transform="translate({j * WIDTH},{i * HEIGHT})">{_panel(panel, f"c{i}{j}")}</g>')
    return "\n".join([*parts, "</svg>\n"])


def _panel(panel: Panel, clip: str) -> str:
    wide, high = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM

    def across(x: FloatArray | float) -> FloatArray:
        scale = np.log10 if panel.logarithmic else np.asarray
        low, up = scale(panel.x_ticks[0]), scale(panel.x_ticks[-1])
        return np.asarray(LEFT + wide * (scale(x) - low) / (up - low))

    def upward(y: FloatArray | float) -> FloatArray:
        low, up = panel.y_ticks[0], panel.y_ticks[-1]
        return np.asarray(TOP + high * (up - np.asarray(y)) / (up - low))

    parts = [
        f'<clipPath id="{clip}"><rect x="{LEFT}" y="{TOP}" width="{wide}" height="{high}"/></clipPath>',
        f'<text x="{LEFT + wide / 2}" y="15" text-anchor="middle" font-weight="bold">{panel.title}</text>',
        f'<text x="{LEFT + wide / 2}" y="{HEIGHT - 6}" text-anchor="middle">{panel.x_label}</text>',
        f'<text transform="translate(12,{TOP + high / 2}) rotate(-90)" text-anchor="middle">{panel.y_label}</text>',
    ]
    for tick in panel.x_ticks:
        x = float(across(tick))
        parts.append(f'<path d="M{x:.1f} {TOP}v{high}" stroke="#ddd"/>')
        parts.append(f'<text x="{x:.1f}" y="{TOP + high + 14}" text-anchor="middle">{tick:g}</text>')
    for tick in panel.y_ticks:
        y = float(upward(tick))
        parts.append(f'<path d="M{LEFT} {y:.1f}h{wide}" stroke="#ddd"/>')
        parts.append(f'<text x="{LEFT - 5}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>')
    parts.append(f'<rect x="{LEFT}" y="{TOP}" width="{wide}" height="{high}" fill="none" stroke="#888"/>')
    for curve in panel.curves:
        abscissa, ordinate = _thinned(np.asarray(curve.x, dtype=float), np.asarray(curve.y, dtype=float))
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across(abscissa), upward(ordinate)))
        if curve.marks:
            dots = [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3"/>' for x, y in zip(across(abscissa), upward(ordinate))]
            parts.append(f'<g fill="{curve.colour}">{"".join(dots)}</g>')
            continue
        dash = f' stroke-dasharray="{curve.dash}"' if curve.dash else ""
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="{curve.colour}" stroke-width="{curve.width}"{dash} '
            f'clip-path="url(#{clip})"/>'
        )
    parts += _legend([curve for curve in panel.curves if curve.label])
    return "".join(parts)


def _legend(curves: Sequence[Curve]) -> list[str]:
    parts = []
    for row, curve in enumerate(curves):
        y = TOP + 14 + 15 * row
        dash = f' stroke-dasharray="{curve.dash}"' if curve.dash else ""
        stroke = f'stroke="{curve.colour}" stroke-width="{max(curve.width, 1.5)}"{dash}'
        line = f'<path d="M{LEFT + 8} {y - 4}h22" {stroke}/>'
        parts.append(f'<circle cx="{LEFT + 19}" cy="{y - 4}" r="3" fill="{curve.colour}"/>' if curve.marks else line)
        parts.append(f'<text x="{LEFT + 36}" y="{y}">{curve.label}</text>')
    return parts


def _thinned(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Reduce a curve to the smallest and largest value of each of many equal pieces."""
    if len(x) <= MOST_POINTS:
        return x, y
    pieces = np.array_split(np.arange(len(x)), MOST_POINTS // 2)
    keep = [sorted({int(p[np.argmin(y[p])]), int(p[np.argmax(y[p])])}) for p in pieces]
    places = np.concatenate([np.array(pair) for pair in keep])
    return x[places], y[places]
