"""A whole run in this process, with the same result as over topics."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.loop.arrays import LoopInputs
from flexros.compile.loop.kernel import compile_loop
from flexros.errors import RunError
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import BASE_FRAME, JointSeries, Log, PoseSeries
from flexros.scenario.sensor_series import sensor_series
from flexros.simulate.plant import delayed_start, diverged_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.scenario.experiment import Experiment

SLICE = 65_536
"""Samples whose noise and disturbances are generated at once [1]."""


class DivergedRunError(RunError):
    """A run whose state became infinite.

    Attributes:
        log: The samples before.
    """

    def __init__(self, message: str, log: Log) -> None:
        super().__init__(message)
        self.log = log


def closed_loop(experiment: Experiment, progress: Callable[[int], None] | None = None) -> Log:
    """Simulate the closed loop of an experiment.

    Args:
        experiment: The experiment.
        progress: Called repeatedly with the number of completed samples.

    Returns:
        The log with all five topics.

    Raises:
        DivergedRunError: The state became infinite; names sample and time and holds the log before.
    """
    scenario, plant, n = experiment.scenario, experiment.plant, experiment.n_samples
    references = experiment.reference_signal
    signals = experiment.signals(scenario.seed)
    kernel = compile_loop(
        experiment.plant_model.functions(experiment.control_function),
        sample_time=experiment.sample_time,
        substeps=scenario.substeps,
        delay=experiment.plant_model.delay,
    )
    state = delayed_start(
        experiment.plant_model.start(experiment.start_state, experiment.start_torque),
        experiment.control_state,
        experiment.start_torque,
        kernel.line_length,
    )
    widths = (plant.n_motors, plant.n_motors, 7, experiment.sensor_timing.size)
    encoder, command, pose, further = (np.full((n, width), np.nan) for width in widths)
    for first in range(0, n, SLICE):
        length = min(SLICE, n - first)
        rows = slice(first, first + length)
        result = kernel.run(
            state,
            length,
            LoopInputs(
                reference=references[rows],
                noise=signals.measurement_errors.rows(first, length),
                disturbance=signals.disturbance.rows(first, length),
                gains=experiment.gains,
            ),
            progress=None if progress is None else partial(_count, progress, first),
        )
        assert result.tool_pose is not None
        encoder[rows], command[rows], pose[rows] = result.encoder, result.command, result.tool_pose
        further[rows] = result.further
        pose[rows, :3] += signals.tool_noise.rows(first, length)
        if result.diverged >= 0:
            end = first + int(result.diverged)
            log = run_log(experiment, encoder[:end], command[:end], pose[:end], further[:end])
            raise DivergedRunError(diverged_text(plant.name, end, experiment.sample_time), log)
        state = result.final
    return run_log(experiment, encoder, command, pose, further)


def run_log(
    experiment: Experiment,
    encoder: FloatArray,
    command: FloatArray,
    pose: FloatArray,
    further: FloatArray | None = None,
) -> Log:
    """Return the log of a run, with all five topics from sample 0 on, and those of further sensors.

    Args:
        experiment: The experiment.
        encoder: Measured motor positions [rad or m], shape (n, M).
        command: Torque commands [Nm or N], shape (n, M).
        pose: Measured tool pose, shape (n, 7).
        further: Values of the further sensors before delay and hold, shape (n, n_further); default: not recorded.
    """
    n, names, reference = len(encoder), experiment.plant.joint_names, experiment.reference
    stamp = stamps_ns(n, experiment.sample_time)
    wanted = reference.tool_pose[:n]
    return Log(
        joint_states=JointSeries(stamp, names, position=encoder),
        joint_commands=JointSeries(stamp, names, effort=command),
        joint_reference=JointSeries(
            stamp,
            names,
            position=reference.motor_position[:n],
            velocity=reference.motor_velocity[:n],
            effort=reference.torque[:n],
        ),
        tool_pose=PoseSeries(stamp, BASE_FRAME, pose[:, :3], pose[:, 3:]),
        tool_reference=PoseSeries(stamp, BASE_FRAME, wanted[:, :3], wanted[:, 3:]),
        provenance=experiment.provenance(),
        other_series={}
        if further is None
        else sensor_series(experiment.plant, experiment.sensor_timing, further, stamp),
    )


def _count(progress: Callable[[int], None], first: int, done: int) -> None:
    progress(first + done)
