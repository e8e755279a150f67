"""Figures of one or several runs as rows with group, name, unit and one value per run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from flexros.analysis.frequency_responses import relative_deviation
from flexros.analysis.pace import LOOP_TOPICS
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.analysis.corners import CornerDeviation
    from flexros.analysis.frequency_responses import LogResponses
    from flexros.analysis.loop_timing import LoopTiming
    from flexros.analysis.pace import Pacing
    from flexros.analysis.path_error import PathError
    from flexros.analysis.path_performance import PathPerformance
    from flexros.analysis.point_to_point import Stop
    from flexros.analysis.run_analysis import Analysis
    from flexros.analysis.tracking import MotorTracking

_Figure: TypeAlias = "tuple[str, str, str, float | str]"
"""Group, name, unit and value of one figure of one run."""


@dataclass(frozen=True)
class FigureRow:
    """One figure of all runs.

    Attributes:
        group: Its group, e.g. "Path".
        name: Its name.
        unit: Its unit, "" where it has none.
        values: Its value in each run as text, "-" where the log does not contain it.
    """

    group: str
    name: str
    unit: str
    values: tuple[str, ...]


def figure_rows(analyses: Sequence[Analysis]) -> tuple[FigureRow, ...]:
    """Collect the figures of all runs; a figure that no run has is omitted.

    Args:
        analyses: The runs.

    Returns:
        Rows grouped as path, each motor, frequency responses, timing.
    """
    columns = [{(group, name, unit): value for group, name, unit, value in _figures(analysis)} for analysis in analyses]
    keys = list(dict.fromkeys(key for column in columns for key in column))
    groups = list(dict.fromkeys(group for group, _, _ in keys))
    keys.sort(key=lambda key: groups.index(key[0]))
    return tuple(FigureRow(*key, tuple(_text(column.get(key)) for column in columns)) for key in keys)


def figure_values(analysis: Analysis) -> tuple[tuple[str, str, str, float | str], ...]:
    """Return group, name, unit and value of every figure of a run, as numbers where they are numbers."""
    return tuple(_figures(analysis))


def _text(value: float | str | None) -> str:
    return value if isinstance(value, str) else number(value)


def _figures(analysis: Analysis) -> Iterator[_Figure]:
    if analysis.path is not None:
        yield from _path(analysis.path)
    if analysis.performance is not None:
        yield from _performance(analysis.performance)
    yield from _corners(analysis.corners)
    yield from _stops(analysis.stops)
    for motor in analysis.motors:
        yield from _motor(motor)
    if analysis.responses is not None:
        yield from _responses(analysis.responses)
    yield from _timing(analysis.timing)


def _path(path: PathError) -> Iterator[_Figure]:
    yield "Path", "path error, max", "mm", 1e3 * path.path.maximum
    yield "Path", "path error, rms", "mm", 1e3 * path.path.rms
    yield "Path", "path error, 95 %", "mm", 1e3 * path.path.percentile_95
    yield "Path", "max at time", "s", path.path.time_of_maximum
    if path.path.position_of_maximum is not None:
        yield "Path", "max at path position", "mm", 1e3 * path.path.position_of_maximum
    yield "Path", "time-synchronised error, max", "mm", 1e3 * path.synchronised.maximum
    yield "Path", "time-synchronised error, rms", "mm", 1e3 * path.synchronised.rms
    if path.orientation is not None:
        yield "Path", "orientation error, max", "mrad", 1e3 * path.orientation.maximum


def _performance(performance: PathPerformance) -> Iterator[_Figure]:
    yield "ISO 9283", "cycles", "", float(performance.cycles)
    yield "ISO 9283", "path accuracy AT_p", "mm", 1e3 * performance.position_accuracy
    if performance.position_repeatability is not None:
        yield "ISO 9283", "path repeatability RT_p", "mm", 1e3 * performance.position_repeatability
    for index, axis in enumerate("abc"):
        if performance.orientation_accuracy is not None:
            yield "ISO 9283", f"path accuracy AT_{axis}", "mrad", 1e3 * float(performance.orientation_accuracy[index])
        if performance.orientation_repeatability is not None:
            turn = float(performance.orientation_repeatability[index])
            yield "ISO 9283", f"path repeatability RT_{axis}", "mrad", 1e3 * turn
    if performance.velocity is not None:
        yield "ISO 9283", "path velocity accuracy AV", "%", 1e2 * performance.velocity.accuracy
        if performance.velocity.repeatability is not None:
            yield "ISO 9283", "path velocity repeatability RV", "%", 1e2 * performance.velocity.repeatability


def _corners(corners: Sequence[CornerDeviation]) -> Iterator[_Figure]:
    if corners:
        yield "ISO 9283", "corners", "", float(len(corners))
        yield "ISO 9283", "corner rounding CR, max", "mm", 1e3 * max(corner.rounding for corner in corners)
        yield "ISO 9283", "corner overshoot CO, max", "mm", 1e3 * max(corner.overshoot for corner in corners)


def _stops(stops: Sequence[Stop]) -> Iterator[_Figure]:
    settled = [stop for stop in stops if stop.positioning is not None]
    if not stops:
        return
    yield "Stops", "stops", "", float(len(stops))
    if len(settled) < len(stops):
        yield "Stops", "not in the band of 0.3 mm", "", float(len(stops) - len(settled))
    columns = {"positioning time": "positioning", "settling time": "settling", "stabilisation time": "stabilisation"}
    for name, field in columns.items():
        if settled:
            yield "Stops", f"{name}, max", "s", max(getattr(stop, field) for stop in settled)
    if settled:
        yield "Stops", "overshoot, max", "mm", 1e3 * max(stop.overshoot or 0.0 for stop in settled)


def _motor(motor: MotorTracking) -> Iterator[_Figure]:
    small, torque = ("mm", "N") if motor.linear else ("mrad", "Nm")
    if motor.tracking is not None:
        yield motor.joint, "tracking error, max", small, 1e3 * motor.tracking.maximum
        yield motor.joint, "tracking error, rms", small, 1e3 * motor.tracking.rms
    if motor.deflection is not None:
        yield motor.joint, "link deflection, max", small, 1e3 * motor.deflection
    if motor.torque_max is not None:
        yield motor.joint, "commanded torque, max", torque, motor.torque_max
    if motor.feedback_rms is not None:
        yield motor.joint, "feedback torque, rms", torque, motor.feedback_rms
    if motor.feedback_share is not None:
        yield motor.joint, "feedback share of torque", "%", 1e2 * motor.feedback_share
    if motor.torque_limit is not None and np.isfinite(motor.torque_limit):
        yield motor.joint, "torque limit", torque, motor.torque_limit
    if motor.saturated_share is not None:
        yield motor.joint, "time at torque limit", "%", 1e2 * motor.saturated_share
    if motor.overload_share:
        yield motor.joint, "time with feedforward above limit", "%", 1e2 * motor.overload_share


def _responses(responses: LogResponses) -> Iterator[_Figure]:
    group = "Responses"
    yield group, "positions", "", float(len(responses.positions))
    if not responses.positions:
        return
    yield group, "lines", "", float(len(responses.positions[0].frequency))
    yield group, "lowest frequency", "Hz", float(responses.positions[0].frequency[0])
    yield group, "highest frequency", "Hz", float(responses.positions[0].frequency[-1])
    shares = [relative_deviation(response) for response in responses.positions]
    for name in shares[0]:
        known = [share for by_output in shares if (share := by_output[name]) is not None]
        if known:
            yield group, f"{name}, standard deviation, median", "%", 1e2 * float(np.median(known))


def _timing(timing: LoopTiming) -> Iterator[_Figure]:
    if timing.real_time is not None:
        yield "Timing", "real time (no: lock-step)", "", "yes" if timing.real_time else "no"
    for name in LOOP_TOPICS:
        topic, arrival = timing.topic(name), timing.arrival(name)
        if topic is not None:
            yield "Timing", f"{name}, samples", "", float(topic.count)
        if arrival is not None:
            yield "Timing", f"{name}, received period, median", "ms", 1e3 * arrival.period_median
            yield "Timing", f"{name}, received period, 99 %", "ms", 1e3 * arrival.period_p99
            yield "Timing", f"{name}, received period, max", "ms", 1e3 * arrival.period_max
            yield "Timing", f"{name}, received jitter std", "µs", 1e6 * arrival.jitter_std
        elif topic is not None and not (timing.real_time and topic.exact):
            yield "Timing", f"{name}, mean period", "ms", 1e3 * topic.mean_period
            yield "Timing", f"{name}, jitter std", "µs", 1e6 * topic.jitter_std
            yield "Timing", f"{name}, jitter 99 %", "µs", 1e6 * topic.jitter_p99
            yield "Timing", f"{name}, jitter max", "µs", 1e6 * topic.jitter_max
    if timing.pacing is not None:
        yield from _pacing(timing.pacing)
    yield "Timing", "missing samples, all topics", "", float(sum(topic.missed for topic in timing.topics))
    yield "Timing", "states without command", "", float(timing.unanswered)


def _pacing(pacing: Pacing) -> Iterator[_Figure]:
    """Figures of the schedule of the plant."""
    figures = (
        ("plant, period, median", "ms", 1e3, pacing.period_median),
        ("plant, period, 99 %", "ms", 1e3, pacing.period_p99),
        ("plant, period, max", "ms", 1e3, pacing.period_max),
        ("plant, start after due, 99 %", "µs", 1e6, pacing.lateness_p99),
        ("plant, start after due, max", "µs", 1e6, pacing.lateness_max),
        ("plant, late cycles", "%", 1e2, pacing.late_share),
        ("plant, missed commands", "", 1.0, pacing.missed_commands),
    )
    for name, unit, factor, value in figures:
        if value is not None:
            yield "Timing", name, unit, factor * value
