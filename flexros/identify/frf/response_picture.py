"""Picture of measured frequency responses with their uncertainty, and of model responses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import plotly.graph_objects as go

from flexros.identify.frf.response_noise import response_noise
from flexros.report.colours import MEASURED
from flexros.report.grid import digits, menu, panels

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.frf.frequency_response import FrequencyResponse

BAND = "rgba(89, 99, 110, 0.25)"
_LOWEST = 0.03
"""The band is drawn down to this share of the magnitude at least, as zero has no logarithm (chosen)."""


@dataclass(frozen=True, eq=False)
class ModelCurve:
    """Responses of a model, drawn with the measured ones.

    Attributes:
        kind: A word for it, shown at the cursor.
        name: Its name in the legend.
        colour: Colour of its line.
        width: Width of its line [px].
        frequency: Frequencies at which it is drawn [Hz], shape (F_m,).
        responses: Its response in each position, shape (F_m, n_y, n_u) each.
    """

    kind: str
    name: str
    colour: str
    width: float
    frequency: FloatArray
    responses: Sequence[ComplexArray]


def position_name(index: int, gears: FloatArray) -> str:
    """Name a position by its number, from 1, and its gear coordinates.

    Args:
        index: Number, from 0.
        gears: Gear coordinates [rad or m], shape (M,).

    Returns:
        E.g. "position 3 (0.2, -0.41)".
    """
    return f"position {index + 1} ({', '.join(f'{value:.2f}' for value in np.asarray(gears) + 0.0)})"


def response_picture(responses: Sequence[FrequencyResponse], models: Sequence[ModelCurve] = ()) -> go.Figure:
    """Draw one panel per pair of input and output; menus choose position, and magnitude or phase.

    Args:
        responses: Measured responses of the positions, at least one, of the same inputs and outputs.
        models: Models to compare with.

    Returns:
        The picture.
    """
    first = responses[0]
    n_y, n_u = first.response.shape[1:]
    titles = [f"{inp} → {out}" for out in first.output_names for inp in first.input_names]
    figure = panels(n_y, n_u, titles, _height(n_y))
    drawn = [
        _curves(response, [model.responses[index] for model in models]) for index, response in enumerate(responses)
    ]
    per_panel = len(drawn[0]) // (n_y * n_u)
    for panel, (row, column) in enumerate(np.ndindex(n_y, n_u)):
        shown = drawn[0][panel * per_panel : (panel + 1) * per_panel]
        for trace in _traces(shown, first.frequency, models, legend=panel == 0):
            figure.add_trace(trace, row=row + 1, col=column + 1)
    figure.update_yaxes(type="log", exponentformat="power", dtick=2)
    figure.update_yaxes(title_text=_magnitude(first), row=(n_y + 1) // 2, col=1)
    figure.update_xaxes(title_text="frequency [Hz]", row=n_y)
    _add_menus(figure, responses, drawn, models)
    return figure


def _height(rows: int) -> int:
    return {1: 380, 2: 260, 3: 210}.get(rows, 150)


def _magnitude(response: FrequencyResponse) -> str:
    units = {f"{out} per {inp}" for out in response.output_units for inp in response.input_units}
    return f"[{units.pop()}]" if len(units) == 1 else f"{response.quantity} per torque [SI]"


def _curves(response: FrequencyResponse, models: list[ComplexArray]) -> list[list[float | None]]:
    """Return what each trace shows in one position, panel by panel: band, magnitudes, phases."""
    noise = response_noise(response)
    deviation = np.full(response.response.shape, np.nan) if noise is None else np.sqrt(noise.variance)
    values = []
    for row, column in np.ndindex(*response.response.shape[1:]):
        given, spread = response.response[:, row, column], deviation[:, row, column]
        size = np.abs(given)
        band = np.concatenate([size + spread, np.maximum(size - spread, _LOWEST * size)[::-1]])
        others = [model[:, row, column] for model in models]
        curves = [band, size, *(np.abs(other) for other in others), np.degrees(np.angle(given))]
        curves += [_unbroken(np.degrees(np.angle(other))) for other in others]
        values += [digits(curve) for curve in curves]
    return values


def _unbroken(phase: FloatArray) -> FloatArray:
    """Mask the points after jumps from one end of the circle to the other, so that no line crosses the panel."""
    jumps = np.concatenate([[False], np.abs(np.diff(phase)) > 180.0])
    return np.where(jumps, np.nan, phase)


def _traces(
    curves: list[list[float | None]], frequency: FloatArray, models: Sequence[ModelCurve], *, legend: bool
) -> list[go.Scatter]:
    traces = [
        go.Scatter(
            x=np.concatenate([frequency, frequency[::-1]]),
            y=curves[0],
            fill="toself",
            fillcolor=BAND,
            mode="lines",
            line={"width": 0},
            hoverinfo="skip",
            name="one standard deviation",
            legendgroup="band",
            showlegend=legend and curves[0][0] is not None,
        )
    ]
    kinds = [None, *models] * 2
    for model, curve in zip(kinds, curves[1:], strict=True):
        traces.append(_line(frequency, curve, model, visible=len(traces) < 2 + len(models), legend=legend))
    return traces


def _line(
    frequency: FloatArray, values: list[float | None], model: ModelCurve | None, *, visible: bool, legend: bool
) -> go.Scatter:
    style: dict[str, Any] = {"mode": "markers", "marker": {"color": MEASURED, "size": 3.5}}
    if model is not None:
        style = {"mode": "lines", "line": {"color": model.colour, "width": model.width}}
    kind = "measured" if model is None else model.kind
    return go.Scatter(
        x=frequency if model is None else digits(model.frequency, 5),
        y=values,
        name="measured" if model is None else model.name,
        legendgroup=kind,
        showlegend=legend,
        visible=visible,
        hovertemplate=f"%{{x:.4g}} Hz: %{{y:.4g}}<extra>{kind}</extra>",
        **style,
    )


def _add_menus(
    figure: go.Figure,
    responses: Sequence[FrequencyResponse],
    drawn: list[list[list[float | None]]],
    models: Sequence[ModelCurve],
) -> None:
    """Add the menus; of the traces of a panel band and magnitudes come first, then phases."""
    n_y, n_u = responses[0].response.shape[1:]
    axes = [f"yaxis{index + 1 if index else ''}" for index in range(n_y * n_u)]
    titled = f"{axes[(n_y - 1) // 2 * n_u]}.title.text"
    size: dict[str, Any] = {titled: _magnitude(responses[0])}
    phase: dict[str, Any] = {titled: "[°]"}
    for axis in axes:
        size |= {f"{axis}.type": "log", f"{axis}.dtick": 2, f"{axis}.autorange": True}
        phase |= {f"{axis}.type": "linear", f"{axis}.dtick": 90, f"{axis}.range": [-190, 190]}
    n_curves = 1 + len(models)
    sized = [*[True] * (1 + n_curves), *[False] * n_curves]
    views = [
        {"label": name, "method": "update", "args": [{"visible": visible * len(axes)}, layout]}
        for name, visible, layout in (
            ("magnitude", sized, size),
            ("phase [°]", [not size_shown for size_shown in sized], phase),
        )
    ]
    menus = [menu(views)]
    if len(drawn) > 1:
        menus.append(menu(_positions(responses, drawn, models), width_ahead=130))
    figure.update_layout(updatemenus=menus)


def _positions(
    responses: Sequence[FrequencyResponse], drawn: list[list[list[float | None]]], models: Sequence[ModelCurve]
) -> list[dict[str, Any]]:
    """Return the entries of the menu of positions; frequencies go with them only where they differ."""
    alike = all(np.array_equal(response.frequency, responses[0].frequency) for response in responses)
    n_y, n_u = responses[0].response.shape[1:]
    modelled = [digits(model.frequency, 5) for model in models]
    buttons = []
    for index, response in enumerate(responses):
        changed: dict[str, Any] = {"y": drawn[index]}
        if not alike:
            frequency = response.frequency.tolist()
            changed["x"] = [frequency + frequency[::-1], *[frequency, *modelled] * 2] * (n_y * n_u)
        label = position_name(index, response.gears)
        buttons.append({"label": label, "method": "restyle", "args": [changed]})
    return buttons
