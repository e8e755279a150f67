"""Frequency response of the linearised robot, and its Bode plot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.atomic_file import write_result

if TYPE_CHECKING:
    from pathlib import Path

    import plotly.graph_objects as go

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.robot.linear.linearise import LinearModel


def frequency_response(linear: LinearModel, frequency: FloatArray) -> ComplexArray:
    """Compute the response G(jw) = C (K + jwD - w^2 M)^-1 B from motor torques to all measurements.

    Args:
        linear: The linear model.
        frequency: Frequencies [Hz], shape (n,).

    Returns:
        Response [rad/Nm, m/Nm, rad/N, m/N], shape (n, M + n_out, M).
    """
    s = 2j * np.pi * frequency[:, None, None]
    dynamic = linear.stiffness + s * linear.damping + s**2 * linear.mass
    C = np.vstack([linear.encoder, linear.output])
    torque = np.broadcast_to(linear.input, (len(s), *linear.input.shape))
    return np.asarray(C @ np.linalg.solve(dynamic, torque), dtype=complex)


def write_bode(linear: LinearModel, file: Path, title: str, low: float = 0.5, high: float = 200.0) -> None:
    """Write a page with a picture for every motor.

    Args:
        linear: The linear model.
        file: HTML file; it opens without a network.
        title: Heading of the page.
        low: Lowest frequency [Hz].
        high: Highest frequency [Hz].
    """
    from flexros.report.base import Picture  # here, because it loads slowly
    from flexros.report.page import Chapter, page_html

    caption = "Positions are drawn as accelerations, so that rigid-body motion is flat."
    chapters = [
        Chapter(f"{_kind(linear, column)} of {name}", (Picture(_figure(linear, [column], low, high), caption),))
        for column, name in enumerate(linear.input_names)
    ]
    subtitle = f"Frequency responses from motors to measurements, {low:g} to {high:g} Hz"
    write_result(file, page_html(title, subtitle, chapters), "Bode picture")


def bode_figure(linear: LinearModel, title: str = "", low: float = 0.5, high: float = 200.0) -> go.Figure:
    """Draw magnitude and phase from every motor torque to every measurement, in acceleration units.

    Positions are plotted as accelerations (times -w^2), as in the thesis, so that rigid-body motion is flat.

    Args:
        linear: The linear model.
        title: Title of the plot; empty for none.
        low: Lowest frequency [Hz].
        high: Highest frequency [Hz].
    """
    figure = _figure(linear, list(range(len(linear.input_names))), low, high)
    return figure.update_layout(title=title or None, hovermode="x unified")


def _kind(linear: LinearModel, column: int) -> str:
    return "Torque" if linear.input_units[column] == "Nm" else "Force"


def _figure(linear: LinearModel, columns: list[int], low: float, high: float) -> go.Figure:
    """Draw two panels, magnitude and phase, for each of some motors."""
    from flexros.report.theme import curve, run_colour, stacked  # here, because plotly loads slowly

    frequency = np.geomspace(low, high, 2000)
    response = -((2 * np.pi * frequency[:, None, None]) ** 2) * frequency_response(linear, frequency)
    titles = [
        f"{_kind(linear, column).lower()} of {linear.input_names[column]}: {what}"
        for column in columns
        for what in ("magnitude", "phase")
    ]
    figure = stacked(titles)
    for place, column in enumerate(columns):
        for row, name in enumerate(linear.measurement_names):
            unit = f"{linear.measurement_units[row]}/s²/{linear.input_units[column]}"
            channel = response[:, row, column]
            magnitude = 20 * np.log10(np.maximum(np.abs(channel), 1e-300))
            phase = np.degrees(np.unwrap(np.angle(channel)))
            for panel, values in enumerate((magnitude, phase)):
                line = curve(
                    frequency,
                    values,
                    f"{name} [{unit}]",
                    run_colour(row),
                    hover="%{y:.4g} at %{x:.4g} Hz",
                    legend=place == panel == 0,
                    group=name,
                )
                figure.add_trace(line, row=2 * place + panel + 1, col=1)
        figure.update_yaxes(title_text="dB", row=2 * place + 1, col=1)
        figure.update_yaxes(title_text="degrees", row=2 * place + 2, col=1)
    figure.update_xaxes(type="log", dtick=1)
    figure.update_xaxes(title_text="frequency [Hz]", row=2 * len(columns), col=1)
    return figure
