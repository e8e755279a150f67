"""Pictures of the blind check: confusion matrix, detection against size, calibration."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from flexros.report.drawing import Drawing, Line, Panel
from flexros.report.theme import GRID, INK, MUTED, run_colour
from flexros.validation.blind.score.answer import NO_GAP, REFUSED, UNKNOWN
from flexros.validation.blind.score.score import confusion, score
from flexros.validation.blind.score.statistics import DetectionCurve, detection_curve

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.validation.blind.score.answer import Answer

_CELL, _LEFT, _TOP = 22, 190, 190
_GAINS = (10.0, 1e6)


def pictures(answers: Sequence[Answer]) -> dict[str, str]:
    """Draw all pictures that the cases allow.

    Args:
        answers: The cases.

    Returns:
        SVG by name.
    """
    drawn = {"confusion": confusion_picture(answers), "detection": detection_picture(answers)}
    calibration = score(answers).calibration
    if calibration is not None:
        ends = (0.0, 1.0)
        even = Line(np.array(ends), np.array(ends), MUTED, 1.0)
        line = Line(np.array(calibration.stated), np.array(calibration.true), run_colour(0), 2.0)
        title = "Share of first causes that were right against the stated probability"
        panel = Panel(title, ends, ends, (even, line), y_log=False)
        drawn["calibration"] = Drawing((panel,), 1, width=420, height=300).svg()
    return drawn


def detection_picture(answers: Sequence[Answer]) -> str:
    """Draw the share of single effects that are seen and named, against their expected gain.

    Args:
        answers: The cases.

    Returns:
        SVG.
    """
    single = [one for one in answers if one.truth.kind == "single"]
    panels = []
    for robot in ("all robots", *sorted({one.truth.robot for one in single})):
        chosen = [one for one in single if robot in ("all robots", one.truth.robot)]
        seen = _curve(chosen, lambda one: one.alarm)
        named = _curve(chosen, lambda one: one.named(1, nested=True))
        lines = [line for place, curve in enumerate((seen, named)) for line in _line(curve, place)]
        title = f"{robot}, {len(chosen)} single effects"
        panels.append(Panel(title, _GAINS, (0.0, 1.0), tuple(lines), x_log=True, y_log=False, levels=(0.5, 0.9)))
    legend = (("gap detected", run_colour(0)), ("right effect first", run_colour(1)))
    return Drawing(tuple(panels), 2, width=300, height=170, legend=legend).svg()


def _curve(answers: Sequence[Answer], found: Callable[[Answer], bool]) -> DetectionCurve:
    gain = np.array([one.truth.gain for one in answers])
    return detection_curve(gain, np.array([found(one) for one in answers], dtype=float))


def _line(curve: DetectionCurve, place: int) -> list[Line]:
    if not np.isfinite(curve.centre):
        return []
    gain = np.geomspace(*_GAINS, 100)
    return [Line(gain, curve.value(gain), run_colour(place), 2.0)]


def confusion_picture(answers: Sequence[Answer]) -> str:
    """Draw the confusion matrix: a row per truth, a column per answer, shares of the row as shades.

    Args:
        answers: The cases.

    Returns:
        SVG.
    """
    table = confusion(answers)
    reported = sorted({name for counts in table.values() for name in counts} - {NO_GAP, UNKNOWN, REFUSED})
    columns = [name for name in table if name in reported]
    columns += [name for name in reported if name not in columns]
    columns += [NO_GAP, UNKNOWN, REFUSED]
    order = [*[name for name in columns if name in table], *[name for name in table if name not in columns]]
    width, height = _LEFT + _CELL * len(columns) + 10, _TOP + _CELL * len(order) + 10
    parts = [
        f'<text x="{_LEFT - 8}" y="{_TOP + _CELL * row + 15}" text-anchor="end" fill="{INK}">{escape(name)}</text>'
        for row, name in enumerate(order)
    ]
    for column, name in enumerate(columns):
        x = _LEFT + _CELL * column + 15
        parts.append(f'<text transform="translate({x},{_TOP - 8}) rotate(-90)" fill="{INK}">{escape(name)}</text>')
    for row, truth in enumerate(order):
        whole = sum(table[truth].values())
        for column, name in enumerate(columns):
            parts.append(_cell(row, column, table[truth].get(name, 0), whole))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="system-ui, sans-serif" font-size="11">'
        f'<rect width="100%" height="100%" fill="#ffffff"/>{"".join(parts)}</svg>\n'
    )


def _cell(row: int, column: int, count: int, whole: int) -> str:
    x, y = _LEFT + _CELL * column, _TOP + _CELL * row
    share = count / whole
    box = (
        f'<rect x="{x}" y="{y}" width="{_CELL}" height="{_CELL}" stroke="{GRID}" fill="{run_colour(0)}" '
        f'fill-opacity="{0.9 * share:.2f}"/>'
    )
    if not count:
        return box
    colour = "#ffffff" if share > 0.5 else INK
    return box + f'<text x="{x + _CELL / 2}" y="{y + 15}" text-anchor="middle" fill="{colour}">{count}</text>'
