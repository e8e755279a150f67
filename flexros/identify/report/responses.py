"""Section: measured responses with their uncertainty, and the model before and after (Paper A, figure 8)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import plotly.graph_objects as go

from flexros.analysis.report.base import Block, Picture
from flexros.identify.graybox.response_noise import response_noise
from flexros.identify.report.base import AbstractIdentificationSection
from flexros.identify.report.grid import digits, menu, panels
from flexros.identify.report.words import position_name

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.report.result import IdentificationResult

BEFORE, AFTER, BAND = "#e69f00", "#d55e00", "rgba(0, 114, 178, 0.22)"
MEASURED = "#0072b2"
_LOWEST = 0.03
"""The band is drawn down to this share of the magnitude at least, as zero has no logarithm (chosen)."""


class ResponseSection(AbstractIdentificationSection):
    """One panel per motor pair; menus choose position, and magnitude or phase."""

    title: ClassVar[str] = "Frequency responses"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return the picture."""
        first = result.problem.responses[0]
        motors = len(first.output_names)
        pairs = [(row, column) for row in range(motors) for column in range(motors)]
        titles = [f"{first.input_names[column]} → {first.output_names[row]}" for row, column in pairs]
        figure = panels(motors, motors, titles, _height(motors))
        drawn = _drawn(result)
        for place, (row, column) in enumerate(pairs):
            for trace in _traces(drawn[0], place, result.problem.frequency, place == 0):
                figure.add_trace(trace, row=row + 1, col=column + 1)
        figure.update_yaxes(type="log", exponentformat="power", dtick=2)
        figure.update_yaxes(title_text=_unit(result), row=(motors + 1) // 2, col=1)
        figure.update_xaxes(title_text="Hz", row=motors)
        _add_menus(figure, result, drawn)
        return (Picture(figure, _caption(result)),)


def _height(motors: int) -> int:
    return {1: 380, 2: 260, 3: 210}.get(motors, 150)


def _unit(result: IdentificationResult) -> str:
    first = result.problem.responses[0]
    units = {f"{out} per {inp}" for out in first.output_units for inp in first.input_units}
    return units.pop() if len(units) == 1 else "acceleration per torque"


def _caption(result: IdentificationResult) -> str:
    bands = [response_noise(response) for response in result.problem.responses]
    band = "; shaded: one standard deviation of the measured response" if any(bands) else ""
    return (
        "Response of the motor accelerations to the motor torques, columns: input, rows: output. Points: measured"
        f"{band}; thin: nominal model, thick: identified model. The menus choose position, and magnitude or phase."
    )


def _drawn(result: IdentificationResult) -> list[list[list[float | None]]]:
    """Return what each trace shows in each position: of all panels the magnitudes, then the phases."""
    nominal = result.problem.model_at(result.nominal).response(result.nominal)
    positions = []
    for place, response in enumerate(result.problem.responses):
        noise = response_noise(response)
        deviation = np.full(response.response.shape, np.nan) if noise is None else np.sqrt(noise.variance)
        models = (nominal[place], result.residuals.response[place])
        values = []
        for row, column in np.ndindex(*response.response.shape[1:]):
            values += _panel(response.response, deviation, models, row, column)
        positions.append(values)
    return positions


def _panel(
    measured: ComplexArray, deviation: FloatArray, models: tuple[ComplexArray, ...], row: int, column: int
) -> list[list[float | None]]:
    """Return the curves of one panel: band, magnitudes and phases of measurement and models."""
    given, spread = measured[:, row, column], deviation[:, row, column]
    size = np.abs(given)
    band = np.concatenate([size + spread, np.maximum(size - spread, _LOWEST * size)[::-1]])
    others = [model[:, row, column] for model in models]
    curves = [band, size, *(np.abs(other) for other in others), np.degrees(np.angle(given))]
    curves += [_unbroken(np.degrees(np.angle(other))) for other in others]
    return [digits(curve) for curve in curves]


def _unbroken(phase: FloatArray) -> FloatArray:
    """Leave out the points after jumps from one end of the circle to the other, so that no line crosses the panel."""
    jumps = np.concatenate([[False], np.abs(np.diff(phase)) > 180.0])
    return np.where(jumps, np.nan, phase)


def _traces(values: list[list[float | None]], panel: int, frequency: FloatArray, legend: bool) -> list[go.Scatter]:
    curves = values[7 * panel : 7 * panel + 7]
    there_and_back = np.concatenate([frequency, frequency[::-1]])
    band = go.Scatter(
        x=there_and_back,
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
    traces = [band]
    for kind, curve in zip(("measured", "nominal", "identified") * 2, curves[1:], strict=True):
        traces.append(_line(frequency, curve, kind, visible=len(traces) < 4, legend=legend))
    return traces


def _line(frequency: FloatArray, values: list[float | None], kind: str, *, visible: bool, legend: bool) -> go.Scatter:
    style: dict[str, Any] = {
        "measured": {"mode": "markers", "marker": {"color": MEASURED, "size": 3.5}},
        "nominal": {"mode": "lines", "line": {"color": BEFORE, "width": 1.2}},
        "identified": {"mode": "lines", "line": {"color": AFTER, "width": 2}},
    }[kind]
    return go.Scatter(
        x=frequency,
        y=values,
        name={"measured": "measured", "nominal": "nominal model", "identified": "identified model"}[kind],
        legendgroup=kind,
        showlegend=legend,
        visible=visible,
        hovertemplate=f"%{{x:.4g}} Hz: %{{y:.4g}}<extra>{kind}</extra>",
        **style,
    )


def _add_menus(figure: go.Figure, result: IdentificationResult, drawn: list[list[list[float | None]]]) -> None:
    motors = len(result.problem.responses[0].output_names)
    axes = [f"yaxis{place + 1 if place else ''}" for place in range(motors**2)]
    shown: dict[str, tuple[list[bool], dict[str, Any]]] = {
        "magnitude": ([*[True] * 4, *[False] * 3] * motors**2, {f"{axis}.type": "log" for axis in axes}),
        "phase [°]": ([*[False] * 4, *[True] * 3] * motors**2, {f"{axis}.type": "linear" for axis in axes}),
    }
    shown["magnitude"][1].update({f"{axis}.dtick": 2 for axis in axes})
    shown["phase [°]"][1].update({f"{axis}.dtick": 90 for axis in axes})
    shown["magnitude"][1].update({f"{axis}.autorange": True for axis in axes})
    shown["phase [°]"][1].update({f"{axis}.range": [-190, 190] for axis in axes})
    for name, unit in (("magnitude", _unit(result)), ("phase [°]", "°")):
        shown[name][1][f"{axes[(motors - 1) // 2 * motors]}.title.text"] = unit
    views = [
        {"label": name, "method": "update", "args": [{"visible": visible}, layout]}
        for name, (visible, layout) in shown.items()
    ]
    menus = [menu(views)]
    if len(drawn) > 1:
        buttons = [
            {
                "label": position_name(place, response.gears),
                "method": "restyle",
                "args": [{"y": drawn[place]}],
            }
            for place, response in enumerate(result.problem.responses)
        ]
        menus.append(menu(buttons, width_ahead=130))
    figure.update_layout(updatemenus=menus)
