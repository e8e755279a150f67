"""The diagnosis of a log, from beginning to end."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import RobotWithEffects
from flexros.errors import InputError
from flexros.gap.answer import result_of
from flexros.gap.explain import explain
from flexros.gap.findings import Findings
from flexros.gap.fit_data import FitData
from flexros.gap.gain import observer_gain
from flexros.gap.predictor import Predictor
from flexros.gap.record import ToolRecord
from flexros.gap.search import Search
from flexros.gap.tolerance import Tolerance, tolerance_of
from flexros.gap.tool_data import tool_data, tracker_noise
from flexros.gap.weights import measurement_of, spread_of
from flexros.gap.where.find import where

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.compile.prediction_loop import Prediction
    from flexros.gap.gain import ObserverGain
    from flexros.gap.record import GapRecord
    from flexros.gap.result import DiagnosisResult, Explanation
    from flexros.gap.weights import Measurement
    from flexros.gap.where.find import Where
    from flexros.robot import Robot


STARTING_LEVEL = 0.3
"""Torque noise that the predictor allows for while it finds the state of a log that begins in motion [1] (chosen)."""
RUN_AWAY = 1e6
"""Largest prediction error over the largest motion of the log; beyond it the prediction has run away [1] (chosen)."""
FIRST_STEP = 0.5
"""Share of a stage that its first step counts for, and of the rest the next ones [1] (chosen)."""
SEEN_BY_TOOL = 1e-3
"""Least rms of a tool error that is more than rounding, over the noise of the tracker [1] (chosen)."""
SAME_RATE = 1e-3
"""Relative difference of sample times up to which two logs have the same rate [1] (chosen)."""
REST = 0.02
"""Time at the begin of a log that tells whether the robot stands still [s] (chosen)."""


@dataclass(frozen=True)
class DiagnosisSettings:
    """Settings of a diagnosis.

    Attributes:
        level: Torque noise that the predictor allows for, see `observer_gain` [1].
        fitted_share: Share of the log that is fitted to where there is no second one [1].
        threads: Fits at the same time; 0: as many as there are cores.
        seed: Seed of the simulated logs without gap.
        where: Whether the places of the gap are looked for.
        next_experiment: Whether an experiment is chosen where the answer is ambiguous.
    """

    level: float = 2e-4
    fitted_share: float = 2 / 3
    threads: int = 0
    seed: int = 1
    where: bool = True
    next_experiment: bool = True


def diagnose(
    record: GapRecord,
    robot: Robot | RobotWithEffects,
    *,
    holdout: GapRecord | None = None,
    tolerance: Mapping[str, float] | None = None,
    settings: DiagnosisSettings | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> DiagnosisResult:
    """Diagnose the gap between a recorded robot and its model.

    Args:
        record: The log that effects are fitted to.
        robot: The nominal model: a robot, or one with effects that are known already.
        holdout: Second log, read once at the end; default: the last third of the first.
        tolerance: Relative tolerance of stiffness, inertia and damping [1]; default: those of the robot file.
        settings: Numbers of the diagnosis.
        progress: Called with the name of the stage and the share of all that is done.

    Returns:
        What was found, with the evidence.
    """
    numbers = settings or DiagnosisSettings()
    model = robot if isinstance(robot, RobotWithEffects) else RobotWithEffects(robot, ())
    stages = Stages(progress)
    fitted, held = (record, holdout) if holdout is not None else split(record, numbers.fitted_share)
    _check_alike(fitted, held)
    data = fit_data(fitted, model, numbers)
    held_data = fit_data(held, model, numbers, data.measurement)
    search = Search(model, data, tolerance_of(model.robot, tolerance or {}), stages.inner)
    search.threads = numbers.threads or search.threads
    stages.begin("causes", 0.85)
    explanations = explain(search)
    stages.begin("held-out data", 0.95)
    found = Findings(model, data, held_data, explanations)
    stages.begin("places", 1.0)
    before = found.explanation(explanations.evidence.nothing)
    places = _places(found, before, numbers.seed) if numbers.where else None
    stages.end()
    return result_of(found, before, places, {**asdict(numbers), **dict(tolerance or {})}, stages.timings)


def _places(found: Findings, before: Explanation, seed: int) -> Where:
    """Look where the gap shows, with what the tool tracker adds."""
    data, nothing = found.data, found.explanations.evidence.nothing
    if data.tool is None:
        return where(before.fit, data.record, found.model.robot, seed)
    residual = data.residuals(nothing.predictor, nothing.theta[:, None])[data.spread.size :, 0]
    tool = data.tool
    time_of = (tool.samples[tool.place] + tool.share) * data.record.sample_time
    record = replace(data.record, tool=ToolRecord(time_of, tool.position))
    error = tool.spread * residual.reshape(-1, 3)
    error[:, np.sqrt(np.mean(error**2, axis=0)) < SEEN_BY_TOOL * tool.spread] = 0.0
    return where(before.fit, record, found.model.robot, seed, tool_error=error)


def split(record: GapRecord, share: float) -> tuple[GapRecord, GapRecord]:
    """Set the last part of a log aside.

    Args:
        record: The log.
        share: Share of it that is fitted to [1].
    """
    border = int(share * record.n_samples)
    return record.part(0, border), record.part(border, record.n_samples)


def fit_data(
    record: GapRecord,
    model: RobotWithEffects,
    settings: DiagnosisSettings,
    measurement: Measurement | None = None,
) -> FitData:
    """Give a log gain, start and weights.

    A log that begins in motion loses its first part, in which a predictor of high gain finds the state.

    Args:
        record: The log.
        model: The nominal model.
        settings: Numbers of the diagnosis.
        measurement: Noise of the encoders as another log of the same robot shows it; None to measure it in this one.

    Raises:
        InputError: The prediction of the nominal model runs away.
    """
    robot = model.robot
    pose = robot.equilibrium(motor_position=np.median(record.position, axis=0))[: robot.n_arm]
    measurement = measurement_of(record, robot) if measurement is None else measurement

    tolerated = measurement.signal_tolerance * np.std(record.torque, axis=0) if measurement.signal_tolerance else None

    def gain_at(level: float) -> ObserverGain:
        return observer_gain(robot, record.sample_time, level, measurement.deviation, pose, tolerated=tolerated)

    nominal = Predictor(model, (), Tolerance(), record.sample_time, measured_torque=record.measured_torque)
    start = robot.equilibrium(motor_position=record.position[0])
    fast = gain_at(STARTING_LEVEL)
    first = np.ptp(record.position[: max(round(REST / record.sample_time), 2)], axis=0)
    if np.any(first > 10 * measurement.deviation):
        cut = min(2 * fast.settling, record.n_samples // 4)
        found = nominal.predict(np.zeros((0, 1)), record.part(0, cut), fast, start)
        start, record = found.final[: len(start), 0], record.part(cut, record.n_samples)
    gain = gain_at(settings.level)
    spread = spread_of(record, gain, measurement)
    samples = None if record.tool is None else np.arange(record.n_samples)
    predicted = nominal.predict(np.zeros((0, 1)), record, gain, start, pose_samples=samples)
    _check_bounded(predicted, record)
    tool = None
    if record.tool is not None:
        assert predicted.tool_pose is not None
        counted = np.all(np.isfinite(spread), axis=1, keepdims=False)
        noise = tracker_noise(record.tool, robot.tool_noise)
        tool = tool_data(record.tool, predicted.tool_pose[:, :, 0], counted, record.sample_time, noise)
    return FitData(record, gain, start, spread, measurement, tool, pose)


def _check_alike(fitted: GapRecord, held: GapRecord) -> None:
    """Refuse a holdout that was recorded in another way, which the predictors of the fit do not fit."""
    ways = [
        f"{one.name} has {1 / one.sample_time:.6g} samples per second and "
        f"{'measured' if one.measured_torque else 'commanded'} torques"
        for one in (held, fitted)
    ]
    if abs(held.sample_time / fitted.sample_time - 1) > SAME_RATE or held.measured_torque != fitted.measured_torque:
        raise InputError(f"{ways[0]}, but {ways[1]}; give a holdout that was recorded like the log, or none")


def _check_bounded(predicted: Prediction, record: GapRecord) -> None:
    """Refuse a log that the nominal model cannot follow at all, as that of a loop which was not stable."""
    farthest = float(np.ptp(record.position, axis=0).max())
    if not np.all(np.abs(predicted.innovation[:, :, 0]) <= RUN_AWAY * farthest):
        raise InputError(
            f"{record.name}: the prediction of the nominal model runs away from this log, in which motors move by up "
            f"to {farthest:.3g} rad or m; check units, signs and order of the motors, and whether the control loop was "
            "stable, or give the log of another run"
        )


class Stages:
    """Tells how far the work is, and keeps the time of every stage.

    Args:
        progress: Called with the name of the stage and the share of all that is done.
    """

    def __init__(self, progress: Callable[[str, float], None] | None) -> None:
        self.timings: dict[str, float] = {}
        self._progress = progress
        self._name, self._from, self._to, self._begin = "", 0.0, 0.0, time.monotonic()
        self._step, self._done, self._span = "", 0.0, 1.0

    def begin(self, name: str, share: float) -> None:
        """Begin a stage that ends when `share` of all is done."""
        self.end()
        self._name, self._from, self._to, self._begin = name, self._to, share, time.monotonic()
        self._step, self._done, self._span = name, 0.0, FIRST_STEP
        self.inner(name, 0.0)

    def inner(self, name: str, share: float) -> None:
        """Tell how far a step of the present stage is; as many steps may come, each counts for half of what is left."""
        if name != self._step:
            self._step, self._done = name, self._done + self._span
            self._span = FIRST_STEP * (1.0 - self._done)
        if self._progress is not None:
            self._progress(name, self._from + (self._done + share * self._span) * (self._to - self._from))

    def end(self) -> None:
        """End the present stage."""
        if self._name:
            self.timings[self._name] = time.monotonic() - self._begin
            self._name = ""
