"""Prediction errors of the motor positions over time and over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import welch

from flexros.report.base import Picture
from flexros.report.colours import NOMINAL, REPAIRED

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from flexros.arrays import FloatArray
    from flexros.gap.prediction.predicted_log import PredictedLog
    from flexros.gap.result import DiagnosisResult, Explanation
    from flexros.record.record import Record

_COLOURS = {"before": NOMINAL, "after": REPAIRED}
_NAMES = {"before": "nominal model", "after": "repaired model"}
_MOST_MOTORS = 3
"""Number of motors drawn, those with the largest gap (chosen)."""
_SEGMENT = 4096
"""Longest segment of the spectra [samples] (chosen)."""
_FARTHEST = 1e6
"""Standard deviations at which errors of diverged predictions are drawn (chosen)."""
_BAND = 1.96
"""Standard deviations that 95 % of normally distributed errors are within."""


def innovation_picture(result: DiagnosisResult) -> Picture:
    """Draw the prediction errors of the nominal and the repaired model, over time and as spectra.

    Args:
        result: The diagnosis.

    Returns:
        The picture, a row of two panels per motor, in standard deviations of a model without a gap.
    """
    record, before = _predicted(result, result.before)
    models = {"before": before}
    if result.after is not None:
        models["after"] = _predicted(result, result.after)[1]
    sizes = np.mean(np.square(_settled(before, record)), axis=0)
    motors = np.sort(np.argsort(-sizes)[:_MOST_MOTORS])
    figure = _empty(result, motors)
    for row, motor in enumerate(motors.tolist(), start=1):
        for key, prediction in models.items():
            _draw(figure, row, key, _settled(prediction, record)[:, motor], record, legend=row == 1)
    log = "the held-out log" if result.holdout is not None else "the fitted log"
    return Picture(
        figure,
        f"Errors of the motor position predicted one sample ahead, in {log}: over time, in standard deviations of a "
        f"model without a gap (95 % would be within ±{_BAND:.0f}), and as a spectrum, over that of white noise of the "
        "same standard deviation.",
    )


def _predicted(result: DiagnosisResult, model: Explanation) -> tuple[Record, PredictedLog]:
    """Return held-out data where there are any, otherwise the fitted ones."""
    if result.holdout is not None and model.holdout is not None and result.before.holdout is not None:
        return result.holdout, model.holdout
    return result.record, model.fit


def _settled(prediction: PredictedLog, record: Record) -> FloatArray:
    """Return the errors in standard deviations, zero where they are not used, shape (n, M)."""
    relative: FloatArray = np.clip(np.nan_to_num(prediction.innovations / prediction.sd), -_FARTHEST, _FARTHEST)
    relative[: prediction.first] = 0.0
    relative[~record.valid] = 0.0
    return relative


def _empty(result: DiagnosisResult, motors: np.ndarray[tuple[int, ...], np.dtype[np.intp]]) -> go.Figure:
    from flexros.report.theme import LOGARITHMIC, stacked

    names = [result.robot.joint_names[motor] for motor in motors.tolist()]
    titles = [title for name in names for title in (f"{name}, over time", f"{name}, spectrum")]
    figure = stacked(titles, columns=2, height=210, shared_x=False, gap=78)
    for row in range(1, len(names) + 1):
        figure.update_xaxes(title_text="time [s]", row=row, col=1)
        figure.update_yaxes(title_text="error / σ", row=row, col=1)
        figure.update_xaxes(title_text="frequency [Hz]", row=row, col=2, **LOGARITHMIC)
        figure.update_yaxes(title_text="power / floor", row=row, col=2, **LOGARITHMIC)
    return figure


def _draw(figure: go.Figure, row: int, key: str, relative: FloatArray, record: Record, *, legend: bool) -> None:
    from flexros.report.theme import curve

    time = record.sample_time * np.arange(len(relative), dtype=float)
    name, colour = _NAMES[key], _COLOURS[key]
    over_time = curve(time, relative, name, colour, hover="%{x:.3f} s: %{y:.3g} σ", legend=legend, group=key, width=1.0)
    figure.add_trace(over_time, row=row, col=1)
    frequency, power = _spectrum(relative, record.sample_time)
    floor = 2 * record.sample_time  # one-sided density of white noise of variance 1
    spectrum = curve(
        frequency[1:],
        np.maximum(power[1:] / floor, 1e-3),
        name,
        colour,
        hover="%{x:.3g} Hz: %{y:.3g}",
        legend=False,
        group=key,
    )
    figure.add_trace(spectrum, row=row, col=2)


def _spectrum(values: FloatArray, sample_time: float) -> tuple[FloatArray, FloatArray]:
    """Return frequencies [Hz] and one-sided power density [1/Hz]."""
    frequency, power = welch(values, 1 / sample_time, nperseg=min(_SEGMENT, len(values)))
    return frequency.astype(np.float64), power.astype(np.float64)
