"""The gap in closed loop: tool and motors of the model against those of the robot, both under the same control."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import RunError
from flexros.gap.result import SignalGap
from flexros.logs.time_series import BASE_FRAME
from flexros.scenario.recorded_experiment import recorded_experiment

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.effects import RobotWithEffects
    from flexros.logs.time_series import Log
    from flexros.scenario.experiment import Experiment

_MILLI = 1e-3


def closed_loop_gap(
    log: Log, nominal: RobotWithEffects, repaired: RobotWithEffects | None = None, *, begin: float = 0.0
) -> tuple[SignalGap, ...]:
    """Simulate the scenario of a log with the nominal and the repaired model as the plant, and compare.

    Reference, feedforward and controller are those of the log's provenance; its plant is not used. The models run
    without noise, so that a perfect model leaves the noise of the log.

    Args:
        log: The log.
        nominal: The nominal model.
        repaired: The model with the effects that were found; None where none were.
        begin: Time in the log from which the difference is evaluated [s].

    Returns:
        Root mean square of the tool's distance in mm and of each motor's difference in mrad or mm; empty where
        reference and controller are not known, or the loop with the nominal model is not stable.
    """
    experiment = recorded_experiment(log)
    if experiment is None or experiment.plant.joint_names != nominal.robot.joint_names:
        return ()
    before = _run(experiment, nominal)
    if before is None:
        return ()
    stamp = log.joint_states.stamp
    rows = np.round((stamp - before.joint_states.stamp[0]) * 1e-9 / experiment.sample_time).astype(np.int64)
    late = (stamp - stamp[0]) * 1e-9 >= begin
    counted = np.flatnonzero(late & (rows >= 0) & (rows < experiment.n_samples))
    if not len(counted):
        return ()
    after = None if repaired is None else _run(experiment, repaired)
    return _gaps(log, before, after, rows, counted, nominal)


def _run(experiment: Experiment, model: RobotWithEffects) -> Log | None:
    """Simulate a model as the plant of an experiment; None where the loop is not stable."""
    from flexros.scenario.closed_loop import closed_loop

    try:
        return closed_loop(replace(experiment, models=replace(experiment.models, plant=model)))
    except RunError:
        return None


def _gaps(
    log: Log, before: Log, after: Log | None, rows: IntArray, counted: IntArray, nominal: RobotWithEffects
) -> tuple[SignalGap, ...]:
    robot, runs = nominal.robot, (before, after)
    gaps = []
    measured, stamp = log.tool_pose, log.joint_states.stamp
    if measured is not None and measured.frame_id == BASE_FRAME and np.array_equal(measured.stamp, stamp):
        paths = [None if run is None or run.tool_pose is None else run.tool_pose.position for run in runs]
        errors = [None if path is None else _rms(measured.position[counted] - path[rows[counted]]) for path in paths]
        assert errors[0] is not None
        floor = float(np.sqrt(3.0) * robot.tool_noise) / _MILLI
        gaps.append(SignalGap("tool path in closed loop", "mm", errors[0], errors[1], floor))
    position = log.joint_states.position
    names = list(log.joint_states.names)
    for motor, name in enumerate(robot.joint_names):
        if position is None or name not in names:
            continue
        recorded = position[counted, names.index(name)]
        simulated = [None if run is None else run.joint_states.position for run in runs]
        errors = [None if run is None else _rms((recorded - run[rows[counted], motor])[:, None]) for run in simulated]
        assert errors[0] is not None
        unit = f"m{robot.motors[motor].position_unit}"
        floor = float(robot.encoder_noise[motor]) / _MILLI
        gaps.append(SignalGap(f"{name} position in closed loop", unit, errors[0], errors[1], floor))
    return tuple(gaps)


def _rms(difference: FloatArray) -> float:
    """Return the root mean square of the length of differences, in thousandths."""
    return float(np.sqrt(np.mean(np.sum(difference**2, axis=1)))) / _MILLI
