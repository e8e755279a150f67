"""Analysis of one run: path error, path performance, corners, tracking, timing and frequency responses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flexros.analysis.corners import CornerDeviation, corner_deviations
from flexros.analysis.cycles import split_cycles
from flexros.analysis.elapsed_time import start_stamp
from flexros.analysis.frequency_responses import LogResponses, log_responses
from flexros.analysis.loop_timing import LoopTiming, loop_timing
from flexros.analysis.path_error import AXES, PathError, path_error
from flexros.analysis.path_performance import POINTS, STANDARD_CYCLES, PathPerformance, path_performance
from flexros.analysis.point_to_point import Stop, stops
from flexros.analysis.torque_limits import limit_warnings, limited_drives
from flexros.analysis.tracking import Drive, MotorTracking, motor_tracking
from flexros.errors import InputError
from flexros.logs.reader import give_memory_back

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import pandas as pd
    import plotly.graph_objects as go

    from flexros.analysis.cycles import Cycle
    from flexros.logs.time_series import Log
    from flexros.robot import Robot

_FOLLOWED = 0.95
"""A tool that crosses a smaller share of the planes along the path does not follow it (chosen)."""


@dataclass(frozen=True, eq=False, repr=False)
class Analysis:
    """Results of the analysis of one run.

    Attributes:
        label: Name of the run in tables and pictures.
        duration: Time from the first to the last joint_states stamp [s].
        path: Error of the tool along its path; None where tool_pose or tool_reference is missing, and for an
            identification experiment, whose excitation is not a path to be followed.
        performance: Path accuracy and repeatability (ISO 9283); None without `path` or where the path does not move.
        corners: Deviations at the corners of the path, in order of travel.
        motors: Tracking and torque of each motor.
        timing: Timing of the topics.
        provenance: Origin of the log.
        warnings: Limits of these results, one sentence each; those of the log first.
        responses: Frequency responses; None where the log is not of an identification experiment.
        stops: Stops after point-to-point moves, in order.
    """

    label: str
    duration: float
    path: PathError | None
    performance: PathPerformance | None
    corners: tuple[CornerDeviation, ...]
    motors: tuple[MotorTracking, ...]
    timing: LoopTiming
    provenance: Mapping[str, Any]
    warnings: tuple[str, ...]
    responses: LogResponses | None = None
    stops: tuple[Stop, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """Return all figures as plain numbers, lists and strings, ready for JSON; units are in the keys."""
        return {
            "label": self.label,
            "duration_s": self.duration,
            "path": None if self.path is None else self.path.as_dict(),
            "performance": None if self.performance is None else self.performance.as_dict(),
            "stops": [stop.as_dict() for stop in self.stops],
            "corners": [corner.as_dict() for corner in self.corners],
            "motors": {motor.joint: motor.as_dict() for motor in self.motors},
            "timing": self.timing.as_dict(),
            "frequency_responses": None if self.responses is None else self.responses.as_dict(),
            "provenance": dict(self.provenance),
            "warnings": list(self.warnings),
        }

    def to_pandas(self) -> pd.DataFrame:
        """Return all figures as a table by group and name, with value and unit."""
        from flexros.analysis.shown import analysis_frame

        return analysis_frame(self)

    def plot(self, what: str = "") -> go.Figure:
        """Draw the path with its error magnified, the errors over time, or the frequency responses.

        Args:
            what: "path", "errors" or "responses"; empty for the first that the log has.

        Raises:
            InputError: The log has no such picture.
        """
        from flexros.analysis.shown import analysis_figure

        return analysis_figure(self, what)

    def __repr__(self) -> str:
        from flexros.analysis.report.summary import verdict

        return f"<Analysis of {self.label}: {verdict([self])}>"

    def _repr_html_(self) -> str:
        from flexros.analysis.shown import analysis_html

        return analysis_html(self)


def analyse(log: Log, *, robot: Robot | None = None, label: str | None = None) -> Analysis:
    """Analyse the log of one run.

    Args:
        log: The log.
        robot: The robot of the run, for its torque limits and controlled axes; None where not known.
        label: Name of the run in tables and pictures; None for the scenario in the provenance.

    Returns:
        The analysis. What the log does not contain is None there and named in the warnings.

    Raises:
        InputError: The log contradicts itself or the robot.
    """
    start = start_stamp(log)
    stamp = log.joint_states.stamp
    warnings = list(log.warnings)
    warnings.extend(_cut_short(log))
    responses = log_responses(log, robot)
    path, performance, corners = (None, None, ()) if responses else _tool(log, start, robot, warnings)
    give_memory_back()  # temporary arrays of a long log, which the next step would need beside its own
    drives = None if robot is None else _drives(robot)
    motors = motor_tracking(log, start, limited_drives(drives, log.joint_states.names, log.provenance, warnings))
    if not any(motor.tracking is not None for motor in motors):
        warnings.append("the log has no joint_reference with positions, so motor tracking is not evaluated")
    if not any(motor.feedforward is not None for motor in motors):
        warnings.append("the log has no feedforward torque, so the share of the feedback is not evaluated")
    give_memory_back()
    warnings.extend(limit_warnings(motors))
    if responses is not None:
        warnings.extend(responses.warnings)
    if responses is not None and responses.reason:
        warnings.append(f"the frequency responses were not estimated: {responses.reason}")
    return Analysis(
        label=_scenario_name(log.provenance) if label is None else label,
        duration=float((stamp[-1] - stamp[0]) * 1e-9) if len(stamp) else 0.0,
        path=path,
        performance=performance,
        corners=corners,
        motors=motors,
        timing=loop_timing(log),
        provenance=log.provenance,
        warnings=tuple(warnings),
        responses=responses,
        stops=() if path is None else stops(path.run),
    )


def _cut_short(log: Log) -> list[str]:
    """Report that a log has fewer samples than its run was planned to have, with the reason if it is known."""
    recorded, planned = len(log.joint_states.stamp), log.provenance.get("n_samples")
    stopped = log.provenance.get("stopped")
    if isinstance(stopped, dict) and {"completed", "planned"} <= set(stopped):
        return [
            f"the experiment was stopped when {stopped['completed']} of {stopped['planned']} experiments were complete"
        ]
    if not isinstance(planned, int) or recorded >= planned:
        return []
    return [f"the log has {recorded} of the {planned} samples of its run, which was aborted or lost samples"]


def _scenario_name(provenance: Mapping[str, Any]) -> str:
    """Return the name of the scenario from the provenance, given directly or in the scenario."""
    scenario = provenance.get("scenario", "")
    name = scenario.get("name", "") if isinstance(scenario, dict) else scenario
    return str(name) or "run"


def _controlled(robot: Robot) -> tuple[tuple[str, ...] | None, bool]:
    """Return the position components that the robot controls (None: those of its joints), and whether it rotates."""
    pose = robot.spec.outputs[robot.controlled].pose
    position = tuple(component for component in pose if component in AXES)
    return position or None, not pose or len(position) < len(pose)


def _drives(robot: Robot) -> tuple[Drive, ...]:
    """Return limit and kind of each motor, in the order of the chain."""
    moved = [axis for body in robot.spec.bodies for axis, direction in body.directions.items() if direction.motor]
    return tuple(
        Drive(joint, float(limit), linear=axis.startswith("t"))
        for joint, limit, axis in zip(robot.joint_names, robot.torque_limits, moved, strict=True)
    )


def _tool(
    log: Log, start: int, robot: Robot | None, warnings: list[str]
) -> tuple[PathError | None, PathPerformance | None, tuple[CornerDeviation, ...]]:
    """Evaluate the tool topics; missing ones are added to the warnings."""
    pose, reference = log.tool_pose, log.tool_reference
    absent = [
        name
        for name, series in (("tool_pose", pose), ("tool_reference", reference))
        if series is None or len(series.stamp) == 0
    ]
    if pose is None or reference is None or absent:
        warnings.append(f"the log has no {' and no '.join(absent)}, so only the motor side of the error is evaluated")
        return None, None, ()
    axes, turned = (None, True) if robot is None else _controlled(robot)
    error = path_error(pose, reference, start=start, axes=axes, turned=turned)
    give_memory_back()
    if error.chord_error > 0.05 * error.path.maximum:
        warnings.append(
            f"the commanded path may deviate from the chords between its samples by {1e3 * error.chord_error:.2g} mm, "
            "which adds to the path error; record tool_reference at a higher rate"
        )
    if error.length == 0.0:
        warnings.append("the commanded tool position never moves, so path accuracy is not evaluated")
        return error, None, ()
    cycles = split_cycles(error.run)
    return error, _performance(cycles, warnings), corner_deviations(cycles)


def _performance(cycles: Sequence[Cycle], warnings: list[str]) -> PathPerformance | None:
    """Evaluate path performance; warn where the tool does not follow the path, as in an aborted run."""
    try:
        performance = path_performance(cycles)
    except InputError as error:
        warnings.append(f"path accuracy was not evaluated: {error}")
        return None
    if performance.points < _FOLLOWED * POINTS:
        warnings.append(
            f"the tool crosses only {performance.points} of {POINTS} planes normal to the commanded path, so path "
            "accuracy is that of a part of it"
        )
    if 1 < performance.cycles < STANDARD_CYCLES:
        warnings.append(f"repeatability is from {performance.cycles} cycles; ISO 9283 requires {STANDARD_CYCLES}")
    return performance
