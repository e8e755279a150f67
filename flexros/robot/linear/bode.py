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
    """Write the picture of `bode_figure` to a file.

    Args:
        linear: The linear model.
        file: HTML file; it opens without a network.
        title: Title of the plot.
        low: Lowest frequency [Hz].
        high: Highest frequency [Hz].
    """
    write_result(file, bode_figure(linear, title, low, high).to_html(include_plotlyjs=True), "Bode picture")


def bode_figure(linear: LinearModel, title: str = "", low: float = 0.5, high: float = 200.0) -> go.Figure:
    """Draw magnitude and phase from every motor torque to every measurement, in acceleration units.

    Positions are plotted as accelerations (times -w^2), as in the thesis, so that rigid-body motion is flat.

    Args:
        linear: The linear model.
        title: Title of the plot; empty for none.
        low: Lowest frequency [Hz].
        high: Highest frequency [Hz].
    """
    import plotly.graph_objects as go  # here, because it loads slowly
    from plotly.subplots import make_subplots

    frequency = np.geomspace(low, high, 2000)
    response = -((2 * np.pi * frequency[:, None, None]) ** 2) * frequency_response(linear, frequency)
    inputs, outputs = linear.input_names, linear.measurement_names
    figure = make_subplots(
        rows=2 * len(inputs),
        cols=1,
        shared_xaxes=True,
        vertical_spacing=0.04,
        subplot_titles=[
            f"{'torque' if unit == 'Nm' else 'force'} of {name}: {what}"
            for name, unit in zip(inputs, linear.input_units)
            for what in ("magnitude", "phase")
        ],
    )
    colours = ["#1f5fa8", "#c8541b", "#2a8a57", "#8c4fa8", "#b8902c", "#3a9bb0", "#a33a55", "#5d6d7e"]
    for column in range(len(inputs)):
        for row, name in enumerate(outputs):
            line = {"color": colours[row % len(colours)], "width": 1.5}
            unit = f"{linear.measurement_units[row]}/s²/{linear.input_units[column]}"
            label = {"name": f"{name} [{unit}]", "legendgroup": name, "showlegend": column == 0, "line": line}
            channel = response[:, row, column]
            magnitude = 20 * np.log10(np.maximum(np.abs(channel), 1e-300))
            figure.add_trace(go.Scatter(x=frequency, y=magnitude, **label), row=2 * column + 1, col=1)
            phase = np.degrees(np.unwrap(np.angle(channel)))
            figure.add_trace(
                go.Scatter(x=frequency, y=phase, **{**label, "showlegend": False}), row=2 * column + 2, col=1
            )
        figure.update_yaxes(title_text="dB", row=2 * column + 1, col=1)
        figure.update_yaxes(title_text="degrees", row=2 * column + 2, col=1)
    figure.update_xaxes(type="log")
    figure.update_xaxes(title_text="frequency [Hz]", row=2 * len(inputs), col=1)
    figure.update_layout(
        title=title or None, template="plotly_white", height=120 + 520 * len(inputs), hovermode="x unified"
    )
    return figure
