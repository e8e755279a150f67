"""The gap that a user feels: how far the tool of the model is from that of the robot, both under the same control."""

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
    """Run the scenario of a log again with the nominal and with the repaired model as the robot, and compare.

    Reference, feedforward and controller are those that the log's provenance names; what it says of the plant is not
    looked at. The models run without noise, so what is left of a perfect one is the noise of the log.

    Args:
        log: The log.
        nominal: The nominal model.
        repaired: The model with the effects that were found; None where none were.
        begin: Time since the log began from which the difference counts [s].

    Returns:
        Root mean square of the tool's distance in mm and of each motor's difference in mrad or mm; nothing where
        reference and controller are not known, or the nominal model does not stay in control.
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
    """Run a model as the robot of an experiment; None where the loop is not stable with it."""
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
    seen = log.tool_pose
    if seen is not None and seen.frame_id == BASE_FRAME and np.array_equal(seen.stamp, log.joint_states.stamp):
        tool = [None if one is None or one.tool_pose is None else one.tool_pose.position for one in runs]
        away = [None if one is None else _rms(seen.position[counted] - one[rows[counted]]) for one in tool]
        assert away[0] is not None
        floor = float(np.sqrt(3.0) * robot.tool_noise) / _MILLI
        gaps.append(SignalGap("tool path in closed loop", "mm", away[0], away[1], floor))
    position = log.joint_states.position
    names = list(log.joint_states.names)
    for motor, name in enumerate(robot.joint_names):
        if position is None or name not in names:
            continue
        moved = position[:, names.index(name)]
        simulated = [None if one is None else one.joint_states.position for one in runs]
        away = [
            None if one is None else _rms((moved[counted] - one[rows[counted], motor])[:, None]) for one in simulated
        ]
        assert away[0] is not None
        unit = f"m{robot.motors[motor].position_unit}"
        floor = float(robot.encoder_noise[motor]) / _MILLI
        gaps.append(SignalGap(f"{name} position in closed loop", unit, away[0], away[1], floor))
    return tuple(gaps)


def _rms(difference: FloatArray) -> float:
    """Return the root mean square of the length of differences, in thousandths."""
    return float(np.sqrt(np.mean(np.sum(difference**2, axis=1)))) / _MILLI
