"""Section: path of the tool with magnified error, and path performance along it."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
import plotly.graph_objects as go

from flexros.analysis.path_error import AXES
from flexros.report.base import FACTORS, AbstractSection, Block, MagnifiedCurve, Picture
from flexros.report.decimate import screen_samples
from flexros.report.number_text import number
from flexros.report.theme import REFERENCE, compact, curve, run_colour, stacked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.path_error import PathError
    from flexros.analysis.run_analysis import Analysis
    from flexros.arrays import FloatArray, IntArray

_SHOWN_SHARE = 0.12
"""Size of the largest drawn error, relative to the size of the path."""


class PathSection(AbstractSection["Sequence[Analysis]"]):
    """Path with the error magnified; accuracy and repeatability along the path where there are cycles."""

    title: ClassVar[str] = "Path"

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return the pictures; none where no run has a path."""
        if all(analysis.path is None for analysis in analyses):
            return ()
        blocks: list[Block] = [path_picture(analyses)]
        if any(analysis.performance is not None and analysis.performance.cycles > 1 for analysis in analyses):
            blocks.append(_performance(analyses))
        return tuple(blocks)


def magnification(error: float, extent: float) -> int:
    """Choose the factor at which an error is clearly visible next to its path.

    Args:
        error: Largest error [m].
        extent: Size of the path [m].

    Returns:
        The largest of `FACTORS` that draws the error no larger than an eighth of the path, at least 1.
    """
    return max((f for f in FACTORS if f * error <= _SHOWN_SHARE * extent), default=1)


def path_picture(analyses: Sequence[Analysis], title: str = "") -> Picture:
    """Draw commanded and attained paths; each attained point is moved away from its nearest path point by the factor.

    Args:
        analyses: The runs; those without a path are left out. All are drawn at one factor.
        title: Title of the picture.

    Returns:
        The picture, with a factor chosen from the largest error.
    """
    shown = [(index, analysis, analysis.path) for index, analysis in enumerate(analyses) if analysis.path is not None]
    axes = _picture_axes([path for _, _, path in shown])
    figure = stacked([title], height=_height([path for _, _, path in shown], axes))
    extent = max(float(np.linalg.norm(np.ptp(path.run.commanded, axis=0))) for _, _, path in shown)
    factor = magnification(max(path.path.maximum for _, _, path in shown), extent)
    for reference in _distinct([path for _, _, path in shown]):
        chosen = screen_samples(1e3 * reference.run.commanded[:, AXES.index(axes[-1])])
        base = _base(reference, axes, reference.run.commanded, chosen)
        figure.add_trace(_line(base, "commanded", REFERENCE, "dot", "commanded"))
    magnified = []
    for index, analysis, path in shown:
        chosen = screen_samples(path.distance)
        worst = np.array([int(np.argmax(path.distance))])
        label = f"{analysis.label}, max {number(1e3 * path.path.maximum, 3)} mm"
        for rows, marked in ((chosen, False), (worst, True)):
            base = _base(path, axes, path.nearest, rows)
            deviation = _base(path, axes, path.run.attained, rows) - base
            magnified.append(MagnifiedCurve(len(figure.data), base, deviation))
            points = base + factor * deviation
            figure.add_trace(
                _worst(points, label, run_colour(index))
                if marked
                else _line(points, label, run_colour(index), "solid", label)
            )
    _axes(figure, axes)
    if len(axes) == 2:
        magnified.append(_room([path for _, _, path in shown], axes, factor, figure))
    caption = (
        "Path of the tool. The distance from the commanded path (dotted) is drawn ×{factor}; "
        "a circle marks the largest error of each run."
    )
    if len(shown[0][2].axes) > len(axes) > 1:
        caption += (
            f" Projection on the {axes[0]}-{axes[1]} plane; errors are of all {len(shown[0][2].axes)} components."
        )
    return Picture(figure, caption, tuple(magnified), factor)


def _picture_axes(paths: Sequence[PathError]) -> tuple[str, ...]:
    """Return the one or two components to draw: those in which the commanded paths extend most."""
    used = [axis for axis in AXES if any(axis in path.axes for path in paths)]
    span = {axis: max(float(np.ptp(path.run.commanded[:, AXES.index(axis)])) for path in paths) for axis in used}
    largest = sorted(used, key=lambda axis: span[axis], reverse=True)[:2]
    axes = tuple(axis for axis in used if axis in largest)
    # A path that is higher than wide is drawn on its side, unless its height is vertical.
    tall = len(axes) == 2 and axes[1] != "z" and span[axes[1]] > span[axes[0]]
    return axes[::-1] if tall else axes


def _height(paths: Sequence[PathError], axes: tuple[str, ...]) -> int:
    """Return the height of the picture [px]: lower where the path is much wider than high."""
    if len(axes) == 1:
        return 380
    wide, high = (max(float(np.ptp(path.run.commanded[:, AXES.index(axis)])) for path in paths) for axis in axes)
    return 440 if wide <= high else max(280, min(440, round(1000 * high / wide)))


def _distinct(paths: Sequence[PathError]) -> list[PathError]:
    """Return one run of each commanded path, so that a common reference is drawn once."""
    kept: list[PathError] = []
    for path in paths:
        same = (
            other.shape == path.shape
            and np.allclose(other.run.commanded[[0, -1]], path.run.commanded[[0, -1]], atol=1e-6)
            for other in kept
        )
        if not any(same):
            kept.append(path)
    return kept


def _base(path: PathError, axes: tuple[str, ...], points: FloatArray, rows: IntArray) -> FloatArray:
    """Return rows of points in the coordinates of the picture [mm]; a path of one component is drawn over time [s]."""
    columns = [1e3 * points[rows, AXES.index(axis)] for axis in axes]
    return np.column_stack([path.run.time[rows], *columns] if len(axes) == 1 else columns)


def _line(points: FloatArray, name: str, colour: str, dash: str, group: str) -> go.Scatter:
    return go.Scatter(
        x=compact(points[:, 0]),
        y=compact(points[:, 1]),
        name=name,
        mode="lines",
        line={"color": colour, "width": 1.6 if dash == "solid" else 1.8, "dash": dash},
        hoverinfo="name",
        legendgroup=group,
    )


def _worst(points: FloatArray, group: str, colour: str) -> go.Scatter:
    return go.Scatter(
        x=compact(points[:, 0]),
        y=compact(points[:, 1]),
        name=f"{group} (here)",
        mode="markers",
        marker={"color": "#ffffff", "size": 9, "line": {"color": colour, "width": 2}},
        hoverinfo="name",
        showlegend=False,
        legendgroup=group,
    )


def _axes(figure: go.Figure, axes: tuple[str, ...]) -> None:
    if len(axes) == 1:
        figure.update_xaxes(title_text="time [s]")
        figure.update_yaxes(title_text=f"{axes[0]} [mm]")
        return
    figure.update_xaxes(title_text=f"{axes[0]} [mm]", constrain="domain")
    figure.update_yaxes(title_text=f"{axes[1]} [mm]", scaleanchor="x", scaleratio=1, constrain="domain")


def _room(paths: Sequence[PathError], axes: tuple[str, ...], factor: int, figure: go.Figure) -> MagnifiedCurve:
    """Add two invisible points next to the paths, so that no line touches the frame at any magnification.

    The figure also states its height over its width, for narrow screens.
    """
    across, up = AXES.index(axes[0]), AXES.index(axes[1])
    low = 1e3 * min(path.run.commanded[:, across].min() for path in paths)
    high = 1e3 * max(path.run.commanded[:, across].max() for path in paths)
    height = 1e3 * paths[0].run.commanded[0, up]
    margin = 0.03 * (high - low)
    room = 1.1e3 * max(path.path.maximum for path in paths)
    rise = 1e3 * (
        max(path.run.commanded[:, up].max() for path in paths) - min(path.run.commanded[:, up].min() for path in paths)
    )
    drawn = factor * room
    figure.update_layout(meta={"shape": float((rise + 2 * drawn) / (high - low + 2 * drawn + 2 * margin))})
    curve = MagnifiedCurve(
        trace=len(figure.data),
        base=np.array([[low - margin, height], [high + margin, height]]),
        deviation=np.array([[-room, 0.0], [room, 0.0]]),
    )
    x, y = (curve.base + factor * curve.deviation).T
    figure.add_trace(
        go.Scatter(x=x, y=y, mode="markers", marker={"opacity": 0}, hoverinfo="skip", showlegend=False, name="")
    )
    return curve


def _performance(analyses: Sequence[Analysis]) -> Picture:
    figure = stacked(["Path accuracy: mean path from commanded path", "Path repeatability: mean + 3 S from mean path"])
    cycles = []
    for index, analysis in enumerate(analyses):
        performance = analysis.performance
        if performance is None or performance.repeatability_along is None:
            continue
        cycles.append(f"{performance.cycles} ({analysis.label})")
        position = 1e3 * performance.position
        for row, values in ((1, performance.accuracy_along), (2, performance.repeatability_along)):
            line = curve(
                position,
                1e3 * values,
                analysis.label,
                run_colour(index),
                hover="%{x:.2f} mm along the path: %{y:.4f} mm",
                legend=row == 1,
            )
            figure.add_trace(line, row=row, col=1)
    figure.update_xaxes(title_text="position along the path [mm]", row=2)
    figure.update_yaxes(title_text="distance [mm]", rangemode="tozero")
    return Picture(figure, f"Path performance after ISO 9283 along the path; cycles: {', '.join(cycles)}.")
