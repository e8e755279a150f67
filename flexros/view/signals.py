"""Series beside the scene, each reduced to the width of a plot without losing its peaks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.analysis.elapsed_time import elapsed_seconds, start_stamp

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.path_error import PathError
    from flexros.arrays import FloatArray
    from flexros.logs.time_series import Log
    from flexros.robot import Robot
    from flexros.view.motion import Motion, PredictedMotion

POINTS = 500
"""Points of a plot (chosen)."""
MOST_CURVES = 6
"""Most curves in a plot (chosen)."""


@dataclass(frozen=True, eq=False)
class SignalPlot:
    """Curves over time.

    Attributes:
        title: What is drawn, with its unit.
        names: Name of each curve.
        time: Instants since the beginning of the log [s], increasing, shape (n,).
        values: The curves, shape (n_curves, n).
    """

    title: str
    names: tuple[str, ...]
    time: FloatArray
    values: FloatArray


def signal_plots(
    log: Log, robot: Robot, motion: Motion, path: PathError | None, predicted: Sequence[PredictedMotion] = ()
) -> tuple[SignalPlot, ...]:
    """Return the plots of a log: path error, tracking error, deflection, torque, and errors of models.

    Where a log has no torque commands the measured torques are drawn, where it has no reference the motor positions.

    Args:
        log: The log.
        robot: Its robot.
        motion: The part of its motion that is shown.
        path: Tool error; None where the log has none.
        predicted: Predictions by models at the instants of the motion.
    """
    grid = np.linspace(motion.time[0], motion.time[-1], POINTS)
    motors, scale, unit = robot.joint_names, 1e3, _unit(robot)
    start = start_stamp(log)
    plots: list[SignalPlot] = []

    def add(title: str, names: Sequence[str], time: FloatArray, values: FloatArray) -> None:
        if len(time) and np.any(np.isfinite(values)):
            kept = np.flatnonzero(np.isfinite(values).any(axis=0))[:MOST_CURVES]
            curves = peaks(time, values[:, kept], grid).T
            plots.append(SignalPlot(title, tuple(names[index] for index in kept), grid, curves))

    if path is not None:
        add("path error [mm]", ("path error",), path.run.time, 1e3 * path.distance[:, None])
    for one in predicted:
        add(f"error of the {one.name} [{unit}]", motors, motion.time, scale * one.motor_error)
    if motion.bent and robot.spring_rows:
        gears = list(robot.gear_rows)
        add(f"deflection [{unit}]", motors, motion.time, scale * (motion.arm - motion.stiff)[:, gears])
    states, reference = log.joint_states, log.joint_reference
    if states.position is not None and reference is not None and reference.position is not None:
        time = elapsed_seconds(states.stamp, start)
        wanted = np.column_stack([
            np.interp(states.stamp, reference.stamp, reference.position[:, column], left=np.nan, right=np.nan)
            for column in range(len(reference.names))
        ])  # fmt: skip
        if wanted.shape == states.position.shape and states.names == reference.names:
            add(f"tracking error [{unit}]", states.names, time, scale * (wanted - states.position))
    commands = log.joint_commands
    if commands is not None and commands.effort is not None:
        add("torque command [Nm]", commands.names, elapsed_seconds(commands.stamp, start), commands.effort)
    time = elapsed_seconds(states.stamp, start)
    if states.effort is not None and (commands is None or commands.effort is None):
        add("measured torque [Nm]", states.names, time, states.effort)
    if states.position is not None and (reference is None or reference.position is None):
        add(f"motor positions [{_unit(robot, '')}]", states.names, time, states.position)
    return tuple(plots)


def peaks(time: FloatArray, values: FloatArray, grid: FloatArray) -> FloatArray:
    """Reduce series to a grid: of the values about each of its instants the one of largest size.

    Args:
        time: Instants [s], increasing, shape (n,).
        values: Series, NaN where there is no value, shape (n, k).
        grid: Instants of the grid [s], evenly spaced and increasing, shape (m,).

    Returns:
        Values at the grid, NaN for a series without any, shape (m, k).
    """
    step = grid[1] - grid[0]
    place = np.round((time - grid[0]) / step).astype(np.int64)
    result = np.full((len(grid), values.shape[1]), np.nan)
    for column in range(values.shape[1]):
        usable = np.flatnonzero((place >= 0) & (place < len(grid)) & np.isfinite(values[:, column]))
        series = values[usable, column]
        order = np.argsort(np.abs(series), kind="stable")
        result[place[usable][order], column] = series[order]
        known = np.isfinite(result[:, column])
        if known.any():  # a slower series is joined between its values and held outside; a plot needs numbers
            result[:, column] = np.interp(grid, grid[known], result[known, column])
    return result


def _unit(robot: Robot, prefix: str = "m") -> str:
    return f"{prefix}rad" if all(motor.rotary for motor in robot.motors) else f"{prefix}rad or {prefix}m"
