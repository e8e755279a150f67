"""A log as labelled arrays (xarray), as a table (pandas), as a picture, and in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import unknown_name
from flexros.logs.time_series import OWN_SERIES, ImuSeries, JointSeries, PoseSeries

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go
    import xarray

    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.time_series import Log, Series

_AXES = {3: ("x", "y", "z"), 4: ("x", "y", "z", "w")}
_UNITS = {
    "position": "rad or m",
    "velocity": "rad/s or m/s",
    "effort": "Nm or N",
    "acceleration": "m/s^2",
    "turning_rate": "rad/s",
    "orientation": "1",
}
_PANELS = (("position", "Motor positions"), ("effort", "Motor torques"), ("error", "Tracking: reference - measured"))


def topics_of(log: Log) -> dict[str, Series]:
    """Return the time series of all recorded topics by name."""
    own = {name: log.series(name) for name in OWN_SERIES}
    return {name: series for name, series in {**own, **log.other_series}.items() if series is not None}


def dataset_of(log: Log, topic: str = "") -> xarray.Dataset:
    """Return time series as labelled arrays.

    Args:
        log: The log.
        topic: Relative name of a topic; empty for all.

    Returns:
        Variables over `time` [s] since the first measurement, and joint or axis: position, velocity, effort of one
        topic; of all topics with the name of the topic before them, NaN where a topic has no sample at a time. Units
        are in the attributes.

    Raises:
        InputError: The topic was not recorded.
    """
    import xarray as xr

    known, start = _topics_and_start(log, topic)
    if topic:
        return _one(known[topic], start)
    parts = [_one(series, start, f"{name}_") for name, series in known.items()]
    whole = xr.merge(parts, join="outer", combine_attrs="override", compat="no_conflicts")
    whole.attrs = {"start_ns": start}
    return whole


def frame_of(log: Log, topic: str = "") -> pd.DataFrame:
    """Return time series as a table over time [s] since the first measurement, one column per quantity and joint.

    Args:
        log: The log.
        topic: Relative name of a topic; empty for all.

    Returns:
        Columns such as "position.motor_1" of one topic, "joint_states.position.motor_1" of all.

    Raises:
        InputError: The topic was not recorded.
    """
    import pandas as pd

    known, start = _topics_and_start(log, topic)
    frames = []
    for name, series in ({topic: known[topic]} if topic else known).items():
        before = "" if topic else f"{name}."
        columns = {
            f"{before}{quantity}.{label}": values[:, index]
            for quantity, values in _quantities(series).items()
            for index, label in enumerate(_labels(series, values))
        }
        frames.append(pd.DataFrame(columns, index=pd.Index(_seconds(series.stamp, start), name="time")))
    return pd.concat(frames, axis=1)


def _topics_and_start(log: Log, topic: str) -> tuple[dict[str, Series], int]:
    """Return the series of a log by topic, one of which may be asked for, and the stamp of its first measurement."""
    known = topics_of(log)
    if topic and topic not in known:
        raise unknown_name("topic", topic, known, "the log")
    start = int(log.joint_states.stamp[0]) if len(log.joint_states.stamp) else 0
    return known, start


def log_figure(log: Log) -> go.Figure:
    """Draw positions with their references, torques, and tracking errors of all motors over time."""
    from flexros.report.theme import REFERENCE, curve, run_colour, stacked

    states, start = log.joint_states, int(log.joint_states.stamp[0])
    errors = _tracking(log)
    titles = [title for kind, title in _PANELS if kind != "error" or errors is not None]
    figure = stacked(titles, height=220)
    time, reference = _seconds(states.stamp, start), log.joint_reference
    effort = log.joint_commands or states
    for index, name in enumerate(states.names):
        colour = run_colour(index)
        if reference is not None and reference.position is not None and name in reference.names:
            wanted, at = reference.position[:, reference.names.index(name)], _seconds(reference.stamp, start)
            text = f"{name}, reference"
            line = curve(
                at, wanted, text, REFERENCE, hover="%{x:.4f} s: %{y:.5g}", dash="dot", legend=False, group=name
            )
            figure.add_trace(line, row=1, col=1)
        if states.position is not None:
            line = curve(time, states.position[:, index], name, colour, hover="%{x:.4f} s: %{y:.5g}", group=name)
            figure.add_trace(line, row=1, col=1)
        if effort.effort is not None and name in effort.names:
            torque, at = effort.effort[:, effort.names.index(name)], _seconds(effort.stamp, start)
            line = curve(at, torque, name, colour, hover="%{x:.4f} s: %{y:.4g}", legend=False, group=name)
            figure.add_trace(line, row=2, col=1)
        if errors is not None:
            line = curve(
                time, 1e3 * errors[:, index], name, colour, hover="%{x:.4f} s: %{y:.4g} 1e-3", legend=False, group=name
            )
            figure.add_trace(line, row=3, col=1)
    for row, text in enumerate(("[rad or m]", "[Nm or N]", "[mrad or mm]")[: len(titles)], start=1):
        figure.update_yaxes(title_text=text, row=row, col=1)
    figure.update_xaxes(title_text="time [s]", row=len(titles), col=1)
    return figure


def log_html(log: Log) -> str:
    """Show the topics of a log with samples, rate and length, and its warnings, in a notebook."""
    from flexros.report.base import Paragraph, TextTable
    from flexros.report.notebook import notebook_html
    from flexros.report.number_text import number

    rows = []
    for name, series in topics_of(log).items():
        length = float(series.stamp[-1] - series.stamp[0]) * 1e-9 if len(series.stamp) else 0.0
        rate = (len(series.stamp) - 1) / length if length else 0.0
        what = ", ".join(_quantities(series))
        rows.append((name, what, str(len(series.stamp)), number(rate), number(length)))
    table = TextTable(("Topic", "quantities", "samples", "rate [Hz]", "length [s]"), tuple(rows), "", left=2)
    warnings = tuple(Paragraph(text, "warning") for text in log.warnings)
    return notebook_html(f"Log of {_scenario(log.provenance)}", (table, *warnings))


def _scenario(provenance: Any) -> str:
    scenario = provenance.get("scenario", "")
    name = scenario.get("name", "") if isinstance(scenario, dict) else scenario
    return str(name) or "a run"


def _tracking(log: Log) -> FloatArray | None:
    """Return reference - measured position at the stamps of the measurement, shape (n, M); None where not known."""
    states, reference = log.joint_states, log.joint_reference
    if states.position is None or reference is None or reference.position is None or not len(reference.stamp):
        return None
    if any(name not in reference.names for name in states.names):
        return None
    columns = [
        np.interp(states.stamp, reference.stamp, reference.position[:, reference.names.index(name)])
        for name in states.names
    ]
    return np.asarray(np.column_stack(columns) - states.position, dtype=float)


def _seconds(stamp: IntArray, start: int) -> FloatArray:
    return np.asarray((stamp - start) * 1e-9, dtype=float)


def _quantities(series: Series) -> dict[str, FloatArray]:
    """Return the recorded quantities of a series by name, each of shape (n, width)."""
    names: tuple[str, ...] = ()
    if isinstance(series, JointSeries):
        names = ("position", "velocity", "effort")
    elif isinstance(series, PoseSeries):
        names = ("position", "orientation")
    elif isinstance(series, ImuSeries):
        names = ("acceleration", "turning_rate")
    return {name: getattr(series, name) for name in names if getattr(series, name) is not None}


def _labels(series: Series, values: FloatArray) -> tuple[str, ...]:
    return series.names if isinstance(series, JointSeries) else _AXES[values.shape[1]]


def _one(series: Series, start: int, before: str = "") -> xarray.Dataset:
    """Label one series; axes of poses and joints are dimensions of their own."""
    import xarray as xr

    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", _seconds(series.stamp, start), {"units": "s"})}
    for name, values in _quantities(series).items():
        dimension = "joint" if isinstance(series, JointSeries) else "axis" if values.shape[1] == 3 else "quaternion"
        unit = "m" if isinstance(series, PoseSeries) and name == "position" else _UNITS[name]
        variables[f"{before}{name}"] = (("time", dimension), values, {"units": unit})
        coordinates[dimension] = (dimension, list(_labels(series, values)), {})
    return xr.Dataset(variables, coordinates, {"start_ns": start})
