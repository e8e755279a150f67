"""Motion of an arm from a log: the robot as its model sees it, and models that predict it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.held_out.errors_ahead import samples_ahead
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.settings import DiagnosisSettings
from flexros.prediction.observer import observer_gain
from flexros.record.read import read_record

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.effects import RobotWithEffects
    from flexros.logs.time_series import Log
    from flexros.record.record import Record
    from flexros.robot import Robot

FRAMES_PER_SECOND = 200.0
"""Most instants kept for each second of motion [1/s] (chosen): slow motion stays smooth."""
MOST_FRAMES = 6000
"""Most instants kept of a log (chosen)."""
LENGTH = 60.0
"""Length of a log that is shown if none is given [s] (chosen): its states fit in memory."""
LEAST_NOISE = 1e-7
"""Encoder noise assumed at least [rad or m] (chosen)."""
_NOTHING = np.zeros((0, 1))


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of one arm.

    Attributes:
        time: Instants since the beginning of the log [s], increasing, shape (n,).
        arm: Arm coordinates [rad or m], shape (n, N).
        stiff: Arm coordinates that the motor positions alone would give, springs stiff [rad or m], shape (n, N).
        motors: Motor positions [rad or m], shape (n, M).
        bent: Whether the arm coordinates were estimated; else they are those of stiff springs.
        note: One sentence: how the arm coordinates were found, or why not.
    """

    time: FloatArray
    arm: FloatArray
    stiff: FloatArray
    motors: FloatArray
    bent: bool
    note: str


@dataclass(frozen=True, eq=False)
class PredictedMotion:
    """Motion predicted by a model 0.1 s ahead, at the instants of the robot's.

    Attributes:
        name: "nominal model" or "repaired model".
        arm: Arm coordinates [rad or m], NaN before the first prediction, shape (n, N).
        motor_error: Measured minus predicted motor positions [rad or m], shape (n, M).
    """

    name: str
    arm: FloatArray
    motor_error: FloatArray


def shown_part(record: Record, first: float, length: float) -> Record:
    """Cut the part of a log that is to be shown.

    Args:
        record: The log.
        first: Beginning of the part since that of the log [s].
        length: Length of the part [s].

    Raises:
        InputError: The part lies outside of the log, or is shorter than 10 samples.
    """
    begin = round(first / record.sample_time)
    end = min(record.n_samples, begin + round(length / record.sample_time))
    if begin < 0 or length <= 0 or end - begin < 10:
        raise InputError(
            f"the part from {first:g} s on of {length:g} s is not in {record.name}, which lasts "
            f"{record.duration:.4g} s; give a part of at least 10 samples",
            argument="first",
        )
    return record.part(begin, end)


def robot_motion(log: Log, model: RobotWithEffects, name: str, first: float = 0.0, length: float = LENGTH) -> Motion:
    """Estimate the motion of the arm from a log with the predictor of a model, which its encoders correct.

    Args:
        log: The log.
        model: The model that estimates the deflection: a repaired one where there is one.
        name: Name of the log, for messages.
        first: Beginning of the part that is shown, since that of the log [s].
        length: Length of that part [s].

    Returns:
        The motion. Where the deflection cannot be estimated, because there is no torque or the prediction runs away, it
        is the motion of the motors with stiff springs, and the note says why.

    Raises:
        InputError: The log has no motor positions of this robot, or no such part.
    """
    try:
        record = _record(log, model.robot, name)
    except InputError as error:
        return _stiff_motion(log, model.robot, name, str(error), first, length)
    record = shown_part(record, first, length)
    try:
        states = _filtered(record, model.commanded_by(record.commands))
    except InputError as error:
        return _stiff_motion(log, model.robot, name, str(error), first, length)
    rows = _frames(record)
    return _motion(model.robot, record, states[rows, : model.robot.n_coordinates], rows)


def predicted_motion(
    log: Log, model: RobotWithEffects, motion: Motion, *, name: str, log_name: str, length: float = LENGTH
) -> PredictedMotion:
    """Predict the motion 0.1 s ahead of the encoders with a model.

    Args:
        log: The log.
        model: The model, with the effects that it knows.
        motion: The motion of the robot; its part of the log is predicted.
        name: Name of the model.
        log_name: Name of the log, for messages.
        length: Length of the part [s].

    Raises:
        InputError: The log has no torques, or the model cannot predict it.
    """
    record = shown_part(_record(log, model.robot, log_name), motion.time[0], length)
    model, robot = model.commanded_by(record.commands), model.robot
    states = _filtered(record, model)
    wanted = np.round((motion.time - record.begin) / record.sample_time).astype(np.int64)
    horizon = samples_ahead(record.sample_time)
    predictor = _predictor(model, record)
    there = (wanted - horizon > predictor.loop.line_length) & (wanted < record.n_samples - 1)
    arm = np.full((len(wanted), robot.n_arm), np.nan)
    error = np.full((len(wanted), robot.n_motors), np.nan)
    if there.any():
        ahead = predictor.ahead(np.zeros(0), record, states, wanted[there] - horizon, horizon, last=1)
        assert ahead.states is not None
        arm[there] = ahead.states[:, 0, : robot.n_arm]
        error[there] = record.position[wanted[there]] - ahead.positions
    return PredictedMotion(name, arm, error)


def _record(log: Log, robot: Robot, name: str) -> Record:
    return replace(read_record(log, robot, name=name, positions=True), tool=None, sensors=())


def _predictor(model: RobotWithEffects, record: Record) -> Predictor:
    return Predictor(model, (), Tolerance(), record.sample_time, measured_torque=record.measured_torque)


def _filtered(record: Record, model: RobotWithEffects) -> FloatArray:
    """Return the states of the model, corrected by the encoders at every sample, shape (n, n_states)."""
    robot = model.robot
    pose = robot.equilibrium(motor_position=np.median(record.position, axis=0))[: robot.n_arm]
    noise = np.maximum(robot.encoder_noise, LEAST_NOISE)
    start, settings = robot.equilibrium(motor_position=record.position[0]), DiagnosisSettings()
    predictor = _predictor(model, record)
    # a high gain follows a robot that its model describes badly; on some robots only the low one is stable
    for level in (settings.residuals.starting_level, settings.level):
        gain = observer_gain(robot, record.sample_time, level, noise, pose)
        states = predictor.predict(_NOTHING, record, gain, start, record_states=True).states
        assert states is not None
        if np.all(np.isfinite(states[:, :, 0])):
            return np.ascontiguousarray(states[:, :, 0])
    raise InputError(f"{record.name}: the prediction of {robot.name} runs away; check robot, signs and units")


def _frames(record: Record) -> IntArray:
    """Return the samples that are kept."""
    step = max(1, round(1 / (FRAMES_PER_SECOND * record.sample_time)), -(-record.n_samples // MOST_FRAMES))
    return np.arange(0, record.n_samples, step)


def _motion(robot: Robot, record: Record, coordinates: FloatArray, rows: IntArray) -> Motion:
    motors = coordinates[:, list(robot.chain.motor_rows)]
    stiff = np.array([robot.chain.arm_from_gears(row) for row in motors], dtype=float)
    note = (
        "The deflection is that of the model, corrected by the motor encoders at every sample; "
        "it is no measurement of the links."
    )
    time = record.begin + rows * record.sample_time
    arm: FloatArray = coordinates[:, : robot.n_arm]
    return Motion(np.asarray(time, dtype=np.float64), arm, stiff, record.position[rows], True, note)


def _stiff_motion(log: Log, robot: Robot, name: str, reason: str, first: float, length: float) -> Motion:
    """Return the motion of the motors with stiff springs."""
    from flexros.analysis.elapsed_time import elapsed_seconds, start_stamp
    from flexros.record.joint_columns import motor_columns

    states = log.joint_states
    if states.position is None:
        raise InputError(f"{name} has no motor positions in joint_states: {reason}")
    columns = motor_columns(states.names, robot.joint_names, f"{name}, joint_states", [], owner=f"robot {robot.name}")
    time = elapsed_seconds(states.stamp, start_stamp(log))
    inside = np.flatnonzero((time >= first) & (time <= first + length))
    if len(inside) < 2:
        raise InputError(f"{name} has no motor positions from {first:g} s to {first + length:g} s; give another part")
    spacing = float(np.median(np.diff(time[inside])))
    rows = inside[:: max(1, round(1 / (FRAMES_PER_SECOND * spacing)), -(-len(inside) // MOST_FRAMES))]
    motors = states.position[rows][:, columns] * 1.0
    gears = motors if np.all(np.isfinite(motors)) else np.nan_to_num(motors)
    stiff = np.array([robot.chain.arm_from_gears(row) for row in gears], dtype=float)
    note = f"No deflection is shown, the springs are drawn stiff: {reason}"
    if not robot.spring_rows:
        note = f"The gears of {robot.name} are rigid: the arm stands where its motors are."
    return Motion(time[rows], stiff, stiff, gears, False, note)
