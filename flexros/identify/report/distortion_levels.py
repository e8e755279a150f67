"""Levels of noise, nonlinear distortions and time variation in measured outputs, as blocks of a report."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
import plotly.graph_objects as go

from flexros.identify.frf.response_picture import position_name
from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.grid import digits, menu, panels
from flexros.report.number_text import percent

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.identify.frf.distortion import Distortion
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.result import IdentificationResult

_LEVELS: tuple[tuple[str, str, str, str, str], ...] = (
    ("output", "frequency", "output", "#1b1f24", "lines"),
    ("total", "frequency", "noise and stochastic distortion", "#0072b2", "lines"),
    ("noise", "frequency", "noise", "#8b949e", "lines"),
    ("time_variation", "frequency", "time variation", "#009e73", "lines"),
    ("odd", "odd_frequency", "odd distortion", "#d55e00", "markers"),
    ("even", "even_frequency", "even distortion", "#cc79a7", "markers"),
)
"""Attribute, its frequencies, its name, colour and how it is drawn."""

_CLEAR = 2.0
"""Distortions above this many times the noise are significant (chosen)."""


class DistortionSection(AbstractSection["IdentificationResult"]):
    """One panel per motor, a menu of positions, and a table of medians."""

    title: ClassVar[str] = "Noise and nonlinear distortions"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return sentence, picture and table; nothing where the responses have no levels."""
        return distortion_blocks(result.problem.responses)


def distortion_blocks(responses: Sequence[FrequencyResponse]) -> tuple[Block, ...]:
    """Show the levels of all positions: one panel per motor, a menu of positions, and a table of medians.

    Args:
        responses: Measured responses of the positions.

    Returns:
        Sentence, picture and table; nothing where the responses have no levels.
    """
    measured = [(index, r.distortion) for index, r in enumerate(responses) if r.distortion is not None]
    if not measured:
        return ()
    names = responses[0].output_names
    return (Paragraph(_sentence(measured, names)), _picture(responses, measured), _table(measured, names))


def relative_level(measured: list[tuple[int, Distortion]], level: str, motor: int) -> float:
    """Compute the median of a level over the output's own, over lines and positions.

    Args:
        measured: Levels by position.
        level: Attribute of `Distortion`.
        motor: Number of the motor, 0-based.

    Returns:
        The share [1]; NaN where it is not known.
    """
    shares = []
    for _, levels in measured:
        frequency = getattr(levels, {"odd": "odd_frequency", "even": "even_frequency"}.get(level, "frequency"))
        if len(frequency):
            output = np.interp(frequency, levels.frequency, levels.output[:, motor])
            shares.append(getattr(levels, level)[:, motor] / output)
    values = np.concatenate(shares) if shares else np.array([])
    values = values[np.isfinite(values)]
    return float(np.median(values)) if values.size else float("nan")


def _sentence(measured: list[tuple[int, Distortion]], names: tuple[str, ...]) -> str:
    noise, odd, even = (
        np.array([relative_level(measured, kind, motor) for motor in range(len(names))])
        for kind in ("noise", "odd", "even")
    )
    text = (
        "Amplitudes of the motor accelerations line by line: what the excitation causes, and what a linear robot "
        "without noise would not show. "
    )
    if not np.any(np.isfinite([odd, even])):
        return f"{text}The excitation left no detection lines out, so odd and even distortions cannot be separated."
    ratio = np.nan_to_num(np.stack([odd, even]) / np.where(noise > 0, noise, np.inf))
    kind, motor = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    size = percent(float((odd, even)[kind][motor]), 2)
    largest = f"{('odd', 'even')[kind]} ones at {names[motor]}, {size} % of the output in the median"
    if ratio[kind, motor] > _CLEAR:
        return (
            f"{text}Nonlinear distortions exceed the noise, most of all {largest}, with noise of "
            f"{percent(float(noise[motor]), 2)} %."
        )
    return f"{text}Nonlinear distortions hardly exceed the noise; the largest are {largest}."


def _picture(responses: Sequence[FrequencyResponse], measured: list[tuple[int, Distortion]]) -> Picture:
    response = responses[0]
    motors = len(response.output_names)
    columns = min(motors, 3)
    rows = -(-motors // columns)
    figure = panels(rows, columns, response.output_names, 230 if motors > 1 else 340, gap=44)
    for motor in range(motors):
        for level in _LEVELS:
            trace = _trace(measured[0][1], level, motor)
            figure.add_trace(trace, row=motor // columns + 1, col=motor % columns + 1)
    figure.update_yaxes(type="log", exponentformat="power", dtick=2)
    figure.update_yaxes(title_text=f"amplitude [{response.output_units[0]}]", col=1)
    figure.update_xaxes(title_text="frequency [Hz]", row=rows)
    if len(measured) > 1:
        buttons = []
        for index, levels in measured:
            traces = [_trace(levels, level, motor) for motor in range(motors) for level in _LEVELS]
            args = [{"x": [list(trace.x) for trace in traces], "y": [list(trace.y) for trace in traces]}]
            name = position_name(index, responses[index].gears)
            buttons.append({"label": name, "method": "restyle", "args": args})
        figure.update_layout(updatemenus=[menu(buttons)])
    return Picture(figure, "Levels of the output of each motor; the menu chooses the position.")


def _trace(levels: Distortion, level: tuple[str, str, str, str, str], motor: int) -> go.Scatter:
    attribute, axis, name, colour, mode = level
    frequency: FloatArray = getattr(levels, axis)
    values: FloatArray = getattr(levels, attribute)[:, motor]
    style = {"line": {"color": colour, "width": 1.4}} if mode == "lines" else {"marker": {"color": colour, "size": 5}}
    return go.Scatter(
        x=digits(frequency, 5),
        y=digits(np.where(values > 0, values, np.nan)),
        mode=mode,
        name=name,
        legendgroup=name,
        showlegend=motor == 0 and bool(np.any(np.isfinite(values))),
        hovertemplate=f"%{{x:.4g}} Hz: %{{y:.3g}}<extra>{name}</extra>",
        **style,
    )


def _table(measured: list[tuple[int, Distortion]], names: tuple[str, ...]) -> TextTable:
    kinds = [(attribute, name) for attribute, _, name, _, _ in _LEVELS if attribute != "output"]
    rows = tuple(
        (
            name,
            *(
                percent(level, 2) if np.isfinite(level := relative_level(measured, kind, motor)) else "-"
                for kind, _ in kinds
            ),
        )
        for motor, name in enumerate(names)
    )
    header = ("Motor", *(f"{name} [%]" for _, name in kinds))
    return TextTable(header, rows, "Levels relative to the output, median over lines and positions.")
