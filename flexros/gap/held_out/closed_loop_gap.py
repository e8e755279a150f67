"""The gap in closed loop: tool and motors of the model against those of the robot, both under the same control."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import RunError
from flexros.gap.result import SignalGap
from flexros.logs.stamps import START_NS
from flexros.logs.time_series import BASE_FRAME, JointSeries, Log
from flexros.scenario.recorded_experiment import recorded_experiment

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.effects import RobotWithEffects
    from flexros.scenario.experiment import Experiment

_MILLI = 1e-3
MOST_SAMPLES = 1_000_000
"""Samples of the longest log whose closed loop is simulated (chosen): a run of half an hour at 2 kHz needs 1.3 GB."""


@dataclass(frozen=True, eq=False)
class _SimulatedRun:
    """What is compared of a simulated run: of half an hour the whole log is a gigabyte.

    Attributes:
        position: Measured motor positions [rad or m], shape (n, M).
        tool: Positions of the tool [m], shape (n, 3).
    """

    position: FloatArray
    tool: FloatArray


def measured_alone(log: Log) -> Log:
    """Return what `closed_loop_gap` needs of a log: positions and provenance; of one that is too long the stamps."""
    too_long = bool(why_not_simulated(log))
    states = log.joint_states
    states = JointSeries(states.stamp, states.names, None if too_long else states.position)
    return Log(states, tool_pose=None if too_long else log.tool_pose, provenance=log.provenance)


def why_not_simulated(log: Log) -> tuple[str, ...]:
    """Return a warning where the scenario of a log is known, but the log too long to simulate it."""
    n = len(log.joint_states.stamp)
    if n <= MOST_SAMPLES or not isinstance(log.provenance.get("scenario"), dict):
        return ()
    return (f"the closed loop is not simulated: the log has {n} samples, simulated are at most {MOST_SAMPLES}",)


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
        reference and controller are not known, the log is too long, or the loop with the nominal model is not stable.
    """
    if why_not_simulated(log):
        return ()
    experiment = recorded_experiment(log)
    if experiment is None or experiment.plant.joint_names != nominal.robot.joint_names:
        return ()
    before = _run(experiment, nominal)
    if before is None:
        return ()
    stamp = log.joint_states.stamp
    rows = np.round((stamp - START_NS) * 1e-9 / experiment.sample_time).astype(np.int64)
    late = (stamp - stamp[0]) * 1e-9 >= begin
    counted = np.flatnonzero(late & (rows >= 0) & (rows < experiment.n_samples))
    if not len(counted):
        return ()
    after = None if repaired is None else _run(experiment, repaired)
    return _gaps(log, before, after, rows, counted, nominal)


def _run(experiment: Experiment, model: RobotWithEffects) -> _SimulatedRun | None:
    """Simulate a model as the plant of an experiment; None where the loop is not stable."""
    from flexros.scenario.closed_loop import closed_loop

    try:
        run = closed_loop(replace(experiment, models=replace(experiment.models, plant=model)))
    except RunError:
        return None
    assert run.joint_states.position is not None
    assert run.tool_pose is not None
    return _SimulatedRun(run.joint_states.position.copy(), run.tool_pose.position.copy())


def _gaps(
    log: Log,
    before: _SimulatedRun,
    after: _SimulatedRun | None,
    rows: IntArray,
    counted: IntArray,
    nominal: RobotWithEffects,
) -> tuple[SignalGap, ...]:
    robot, runs = nominal.robot, (before, after)
    gaps = []
    measured, stamp = log.tool_pose, log.joint_states.stamp
    if measured is not None and measured.frame_id == BASE_FRAME and np.array_equal(measured.stamp, stamp):
        paths = [None if run is None else run.tool for run in runs]
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
        simulated = [None if run is None else run.position for run in runs]
        errors = [None if run is None else _rms((recorded - run[rows[counted], motor])[:, None]) for run in simulated]
        assert errors[0] is not None
        unit = f"m{robot.motors[motor].position_unit}"
        floor = float(robot.encoder_noise[motor]) / _MILLI
        gaps.append(SignalGap(f"{name} position in closed loop", unit, errors[0], errors[1], floor))
    return tuple(gaps)


def _rms(difference: FloatArray) -> float:
    """Return the root mean square of the length of differences, in thousandths."""
    return float(np.sqrt(np.mean(np.sum(difference**2, axis=1)))) / _MILLI
