"""Small static pictures for results that are kept with the project: panels with axes, lines and bands, as SVG."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from flexros.report.theme import GRID, INK, MUTED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

_LEFT, _RIGHT, _TOP, _BOTTOM, _GAP = 52.0, 10.0, 24.0, 30.0, 8.0


@dataclass(frozen=True, eq=False)
class Line:
    """One line of a panel.

    Attributes:
        x: Abscissa, shape (n,).
        y: Ordinate, shape (n,).
        colour: Colour.
        width: Width [px].
        opacity: 0 to 1.
    """

    x: FloatArray
    y: FloatArray
    colour: str
    width: float = 1.2
    opacity: float = 1.0


@dataclass(frozen=True, eq=False)
class Band:
    """The area between two lines.

    Attributes:
        x: Abscissa, shape (n,).
        low: Lower line, shape (n,).
        high: Upper line, shape (n,).
        colour: Colour.
    """

    x: FloatArray
    low: FloatArray
    high: FloatArray
    colour: str


@dataclass(frozen=True, eq=False)
class Panel:
    """One panel; both ranges may be logarithmic.

    Attributes:
        title: Text above.
        x_range: Ends of the abscissa.
        y_range: Ends of the ordinate.
        items: Bands and lines, drawn in order.
        x_log: Whether the abscissa is logarithmic.
        y_log: Whether the ordinate is logarithmic.
        levels: Ordinates of dotted lines.
    """

    title: str
    x_range: tuple[float, float]
    y_range: tuple[float, float]
    items: tuple[Line | Band, ...]
    x_log: bool = False
    y_log: bool = True
    levels: tuple[float, ...] = ()


@dataclass(frozen=True)
class Drawing:
    """Panels in rows.

    Attributes:
        panels: The panels, row by row.
        columns: Panels side by side.
        width: Width of a panel without its labels [px].
        height: Height of a panel without its labels [px].
        legend: Names and colours below the panels.
    """

    panels: tuple[Panel, ...]
    columns: int
    width: float = 240.0
    height: float = 150.0
    legend: tuple[tuple[str, str], ...] = field(default=())

    def svg(self) -> str:
        """Return the picture as SVG text."""
        across, down = self.width + _LEFT + _RIGHT, self.height + _TOP + _BOTTOM
        rows = -(-len(self.panels) // self.columns)
        body = [self._panel(panel, index, across, down) for index, panel in enumerate(self.panels)]
        x, y = _LEFT, down * rows + 12
        for name, colour in self.legend:
            room = 40 + 6.5 * len(name)
            if x > _LEFT and x + room > across * self.columns:
                x, y = _LEFT, y + 18
            body.append(f'<path d="M{x:.0f} {y:.0f}h18" stroke="{colour}" stroke-width="3"/>')
            body.append(_text(x + 23, y + 4, name))
            x += room
        total = y + 12 if self.legend else down * rows
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {across * self.columns:.0f} {total:.0f}" '
            'font-family="system-ui, sans-serif" font-size="11">'
            f'<rect width="100%" height="100%" fill="#ffffff"/>{"".join(body)}</svg>\n'
        )

    def _panel(self, panel: Panel, index: int, across: float, down: float) -> str:
        left, top = (index % self.columns) * across + _LEFT, (index // self.columns) * down + _TOP
        parts = [
            f'<clipPath id="c{index}"><rect width="{self.width}" height="{self.height}"/></clipPath>',
            f'<rect width="{self.width}" height="{self.height}" fill="none" stroke="#8b949e"/>',
            _text(0, -_GAP, panel.title, INK),
        ]
        for value, name in _ticks(panel.x_range, panel.x_log):
            x = self.width * float(_share(np.array(value), panel.x_range, panel.x_log))
            parts.append(f'<path d="M{x:.1f} 0v{self.height}" stroke="{GRID}"/>')
            parts.append(_text(x, self.height + 14, name, anchor="middle"))
        for value, name in _ticks(panel.y_range, panel.y_log):
            y = self.height * (1 - float(_share(np.array(value), panel.y_range, panel.y_log)))
            parts.append(f'<path d="M0 {y:.1f}h{self.width}" stroke="{GRID}"/>')
            parts.append(_text(-5, y + 4, name, anchor="end"))
        for level in panel.levels:
            y = self.height * (1 - float(_share(np.array(level), panel.y_range, panel.y_log)))
            parts.append(f'<path d="M0 {y:.1f}h{self.width}" stroke="{INK}" stroke-dasharray="3 3"/>')
        drawn = "".join(self._item(panel, item) for item in panel.items)
        parts.append(f'<g clip-path="url(#c{index})">{drawn}</g>')
        return f'<g transform="translate({left:.1f} {top:.1f})">{"".join(parts)}</g>'

    def _item(self, panel: Panel, item: Line | Band) -> str:
        if isinstance(item, Line):
            points = self._points(panel, item.x, item.y)
            style = f'stroke="{item.colour}" stroke-width="{item.width}" stroke-opacity="{item.opacity}"'
            return f'<polyline points="{points}" fill="none" {style}/>'
        low, high = self._points(panel, item.x, item.low), self._points(panel, item.x[::-1], item.high[::-1])
        return f'<polygon points="{low} {high}" fill="{item.colour}"/>'

    def _points(self, panel: Panel, x: FloatArray, y: FloatArray) -> str:
        across = self.width * np.clip(_share(x, panel.x_range, panel.x_log), -1, 2)
        up = self.height * (1 - np.clip(_share(y, panel.y_range, panel.y_log), -1, 2))
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, up, strict=True))


def _share(values: FloatArray, ends: tuple[float, float], logarithmic: bool) -> FloatArray:
    """Position of values between the ends, 0 to 1."""
    if logarithmic:
        tiny = np.finfo(float).tiny
        values, ends = np.log(np.maximum(values, tiny)), (float(np.log(ends[0])), float(np.log(ends[1])))
    return np.asarray(np.nan_to_num((values - ends[0]) / (ends[1] - ends[0]), nan=2.0, posinf=2.0, neginf=-1.0))


def _ticks(ends: tuple[float, float], logarithmic: bool) -> Sequence[tuple[float, str]]:
    """Choose round values between the ends."""
    if not logarithmic:
        step = 10.0 ** np.floor(np.log10(ends[1] - ends[0]))
        step = step / 2 if (ends[1] - ends[0]) / step < 4 else step * (2 if (ends[1] - ends[0]) / step > 6 else 1)
        values = np.arange(np.ceil(ends[0] / step), np.floor(ends[1] / step) + 1) * step
        return [(float(value), f"{value:g}") for value in values]
    first, last = int(np.floor(np.log10(ends[0]))), int(np.ceil(np.log10(ends[1])))
    factors = (1, 2, 5) if last - first <= 2 else (1,)
    values = np.array([factor * 10.0**power for power in range(first, last + 1) for factor in factors])
    inside = values[(values >= ends[0] * 0.999) & (values <= ends[1] * 1.001)]
    return [(float(value), f"{value:g}") for value in inside]


def _text(x: float, y: float, text: str, colour: str = MUTED, anchor: str = "start") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}">{escape(text)}</text>'
