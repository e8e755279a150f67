"""Iterative learning control: the reference of a repeated motion is corrected by the tool error of the run before."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.feedforward.compensation.compensation import motor_delays
from flexros.feedforward.dae import DaeFeedforward
from flexros.feedforward.hold import held_torque, samples_ahead
from flexros.feedforward.motion import Motion
from flexros.feedforward.problem import FeedforwardProblem
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.scenario.closed_loop import closed_loop

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.feedforward.motion import Reference
    from flexros.logs.time_series import Log
    from flexros.scenario.experiment import Experiment


RISE = 0.02
"""Time within which the correction rises from zero at the start [s] (chosen): the motion begins at rest."""


@dataclass(frozen=True)
class LearningSettings:
    """Settings of the learning law.

    Attributes:
        trials: Number of runs, the first without a correction.
        gain: Share of the error that a run corrects [1].
        bandwidth: Cut-off of the zero-phase low-pass Q [Hz].
        order: Order of the low-pass in each direction.
    """

    trials: int = 8
    gain: float = 0.8
    bandwidth: float = 50.0
    order: int = 2


@dataclass(frozen=True, eq=False)
class Learning:
    """Result of the learning.

    Attributes:
        largest: Largest distance of the tool from its reference in each run [m], shape (trials,).
        rms: Root mean square of that distance in each run [m], shape (trials,).
        correction: Learned correction of the output [m], shape (n, n_out).
        reference: Reference of the last run.
        log: Log of the last run.
    """

    largest: FloatArray
    rms: FloatArray
    correction: FloatArray
    reference: Reference
    log: Log


def learn(
    experiment: Experiment, settings: LearningSettings, progress: Callable[[int], None] | None = None
) -> Learning:
    """Repeat an experiment and learn a correction of its output from the measured tool.

    With the tool error e_j = Z_d - Z of run j and a zero-phase low-pass Q,

        w_(j+1) = Q (w_j + gain e_j),   w_0 = 0,   r_j = r_0 + F(Z_d + w_j) - F(Z_d),

    where F is the inverse dynamics of the nominal robot (the DAE): motor references and torques. Whatever feedforward
    the scenario has makes r_0. The error falls where |1 - gain G F| < 1 within the band of Q (Norrlöf 2000, cited in
    Moberg 2007, section 2.3.2). Every run has noise of its own.

    Args:
        experiment: The experiment; its tool is measured by the tracker.
        settings: The learning law.
        progress: Called with the number of runs.

    Raises:
        InputError: The output is no tool position, or not minimum phase, or settings are out of range.
    """
    _check(experiment, settings)
    wanted, correction = experiment.reference.output, np.zeros_like(experiment.reference.output)
    inverse, largest, rms = _Inverse(experiment), [], []
    for trial in range(settings.trials):
        reference = inverse.corrected(experiment.reference, correction)
        run = _with_reference(experiment, reference, trial)
        log = closed_loop(run)
        assert log.tool_pose is not None
        error = wanted - _output(experiment, log)
        distance = np.linalg.norm(error, axis=1)
        largest.append(float(distance.max()))
        rms.append(float(np.sqrt(np.mean(distance**2))))
        if progress is not None:
            progress(trial + 1)
        if trial + 1 < settings.trials:
            correction = _improved(experiment, settings, correction, error)
    return Learning(np.array(largest), np.array(rms), correction, reference, log)


def _check(experiment: Experiment, settings: LearningSettings) -> None:
    pose = experiment.trajectory.joints or not experiment.nominal.spec.outputs[experiment.trajectory.output].pose
    if pose or set(experiment.nominal.spec.outputs[experiment.trajectory.output].pose) - {"x", "y", "z"}:
        raise InputError(
            f"scenario {experiment.scenario.name} has no path of tool positions, which learning measures; give a "
            "scenario whose trajectory has an output with x, y or z"
        )
    nyquist = 0.5 / experiment.sample_time
    if not 0.0 < settings.bandwidth < nyquist:
        raise InputError(f"the bandwidth is {settings.bandwidth:g} Hz, allowed is above 0 and below {nyquist:g} Hz")
    if settings.trials < 2:
        raise InputError(f"{settings.trials} runs are asked for, but learning needs at least 2")
    if not 0.0 < settings.gain <= 1.0:
        raise InputError(f"the gain is {settings.gain:g}, allowed is above 0 and at most 1")


def _output(experiment: Experiment, log: Log) -> FloatArray:
    """Return the measured output [m], shape (n, n_out)."""
    assert log.tool_pose is not None
    components = experiment.nominal.spec.outputs[experiment.trajectory.output].pose
    return np.asarray(log.tool_pose.position[:, ["xyz".index(name) for name in components]])


def _improved(
    experiment: Experiment, settings: LearningSettings, correction: FloatArray, error: FloatArray
) -> FloatArray:
    """Return the correction of the output for the next run; it begins and ends flat."""
    from scipy.signal import butter, sosfiltfilt  # loads slowly

    low_pass = butter(settings.order, settings.bandwidth, fs=1.0 / experiment.sample_time, output="sos")
    total = correction + settings.gain * error
    pad = min(len(total) - 1, round(2.0 / settings.bandwidth / experiment.sample_time))
    smooth = sosfiltfilt(low_pass, total, axis=0, padtype="constant", padlen=pad)
    rise = min(len(total), round(RISE / experiment.sample_time))
    share = np.linspace(0.0, 1.0, rise)[:, None]
    smooth[:rise] *= share**4 * (35.0 - 84.0 * share + 70.0 * share**2 - 20.0 * share**3)
    return np.asarray(smooth)


class _Inverse:
    """Motor references and torques that move the output of the nominal robot by a correction."""

    def __init__(self, experiment: Experiment) -> None:
        known = experiment.models.known
        robot, self._step = known.robot, experiment.sample_time
        self._delays = motor_delays(robot, known.laws)
        self._n = experiment.n_samples
        self._ahead = samples_ahead(self._step, max(self._delays))
        specification = FeedforwardSpecification(method="dae", non_minimum_phase="refuse")
        self._problem = FeedforwardProblem(
            robot, experiment.trajectory, specification, self._step, self._n + self._ahead, experiment.start
        )
        self._plain = self._motion(self._problem.desired)

    def corrected(self, planned: Reference, correction: FloatArray) -> Reference:
        """Return the planned reference, changed by what the correction of the output needs."""
        if not np.any(correction):
            return planned
        beyond = np.tile(correction[-1], (self._ahead, 1))
        moved = self._motion(self._problem.desired + np.concatenate([correction, beyond]))
        rows = slice(0, self._n)
        torque = np.empty_like(planned.torque)
        for motor, delay in enumerate(self._delays):
            part = slice(0, self._n + samples_ahead(self._step, delay)), slice(motor, motor + 1)
            load, momentum = (
                getattr(moved, key)[part] - getattr(self._plain, key)[part] for key in ("load", "momentum")
            )
            torque[:, part[1]] = held_torque(load, momentum, self._step, delay)
        return replace(
            planned,
            motor_position=planned.motor_position + (moved.motor_position - self._plain.motor_position)[rows],
            motor_velocity=planned.motor_velocity + (moved.motor_velocity - self._plain.motor_velocity)[rows],
            torque=planned.torque + torque,
        )

    def _motion(self, desired: FloatArray) -> Motion:
        problem = replace(self._problem, given_output=desired)
        return Motion.concatenate(list(DaeFeedforward().motions(problem, 4096)))


def _with_reference(experiment: Experiment, reference: Reference, trial: int) -> Experiment:
    """Return the experiment with another reference and noise of its own, started as before."""
    scenario = experiment.scenario.with_values({"seed": experiment.scenario.seed + trial})
    return replace(experiment, scenario=scenario, given_reference=reference)
