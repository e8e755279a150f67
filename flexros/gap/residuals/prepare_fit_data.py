"""Preparation of a log for a fit: observer gain, initial state and weights of its prediction errors."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.gap.noise.weights import measurement_of, spread_of
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.initial_state_errors import initial_state_errors
from flexros.gap.residuals.lost_commands import check_enough_left, lost_commands
from flexros.gap.residuals.observed_model import NOTHING, ObservedModel
from flexros.gap.residuals.sensor_data import sensor_data
from flexros.gap.residuals.tool_data import tool_data, tracker_noise
from flexros.gap.residuals.tool_frame import FEWEST, usable_poses
from flexros.record.balance.spectra import rotor_unknown

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.compile.loop.prediction import LoopPrediction
    from flexros.effects import RobotWithEffects
    from flexros.gap.noise.weights import Measurement
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.observed_model import Beginning
    from flexros.gap.settings import DiagnosisSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

RUN_AWAY = 1e6
"""Largest prediction error over the largest motion of the log; beyond it the prediction has diverged [1] (chosen)."""


def fit_data(
    record: Record,
    model: RobotWithEffects,
    settings: DiagnosisSettings,
    measurement: Measurement | None = None,
    torque_noise: float | None = None,
    around: tuple[Predictor, FloatArray] | None = None,
) -> FitData:
    """Prepare a log for a fit: compute observer gain, initial state and weights.

    The predictor trusts the torques as `settings.level` says. Where the nominal model is so far off that predictions
    stray from the log, no candidate can be judged around them: then it follows the encoders more closely. So it does
    where its gain would settle too late in a simulated log: the gain is that of one pose, and an error that lasts for
    half a minute meets others. A rigid arm of six axes, sampled every 4 ms for 16 s, looked coloured without any gap.

    A log that begins at rest is used from its first sample, with initial-state errors projected out. One that begins
    in motion loses its first part, in which a predictor of high gain estimates the state, and is used once an error of
    that estimate has decayed.

    Args:
        record: The log.
        model: The nominal model.
        settings: Settings of the diagnosis.
        measurement: Noise of the encoders from another log of the same robot; None to measure it in this one.
        torque_noise: What the predictor allows for, as for another log of the same robot [1]; None to choose it.
        around: Predictor and parameters of an explanation, around which the log is weighed in place of the nominal
            model: how far that one is off does not matter then.

    Raises:
        InputError: The prediction diverges.
    """
    measurement = measurement_of(record, model.robot, settings) if measurement is None else measurement
    nominal = ObservedModel.of(record, model, measurement, settings.residuals)
    beginning = nominal.beginning()
    around = (nominal.predictor, NOTHING[:, 0]) if around is None else around
    if torque_noise is None and record.premises.floor_is_noise:
        data, predicted = _followed(nominal, beginning, settings, around)
    else:  # a measured log is tied as its tolerance says
        noise = settings.level if torque_noise is None else torque_noise
        data, predicted = _weighed(nominal, beginning, settings, noise, around)
    _check_bounded(predicted, beginning.record, model.robot)
    data = _with_tool(data, *around)
    if record.sensors:
        data = _with_sensors(data, nominal.predictor, data.predict(nominal.predictor, NOTHING, record_states=True))
    return _with_initial_state_errors(data, *around)


def with_tool_frame_of(data: FitData, predictor: Predictor, theta: FloatArray) -> FitData:
    """Transform the tool measurement to the frame of another prediction than that of the nominal model.

    Frame and offset of a tracker are exact only for the prediction that they were estimated with: where tolerated
    parameters turn the tool by 2e-4 rad more, an offset of 15 mm leaves 3 um, as a kinematic error would.

    Args:
        data: Log and weights.
        predictor: Predictor of the model.
        theta: Its parameters, shape (n_fitted,).
    """
    if data.tool is None:
        return data
    return _with_initial_state_errors(_with_tool(data, predictor, theta), predictor, theta)


def _followed(
    nominal: ObservedModel,
    beginning: Beginning,
    settings: DiagnosisSettings,
    around: tuple[Predictor, FloatArray],
) -> tuple[FitData, LoopPrediction]:
    """Weigh a log with an observer that settles early and follows it more closely while the model is far off."""
    numbers = settings.residuals
    least = nominal.settled_level(settings.level, beginning.record.n_samples)
    data, predicted = _weighed(nominal, beginning, settings, least, around)
    while not data.nominal_level <= numbers.far_off and 10 * data.torque_noise <= numbers.starting_level:
        data, predicted = _weighed(nominal, beginning, settings, 10 * data.torque_noise, around)
    return replace(data, least_torque_noise=least), predicted


def _weighed(
    nominal: ObservedModel,
    beginning: Beginning,
    settings: DiagnosisSettings,
    torque_noise: float,
    around: tuple[Predictor, FloatArray],
) -> tuple[FitData, LoopPrediction]:
    """Weigh the motors of a log, and predict it.

    Args:
        nominal: The nominal model.
        beginning: How the log begins.
        settings: Settings of the diagnosis.
        torque_noise: What the observer allows for, relative [1].
        around: Predictor and parameters of what predicts the log.
    """
    record, gain, measurement = beginning.record, nominal.gain(torque_noise), nominal.measurement
    lost = lost_commands(record, nominal.predictor, gain, beginning.state, nominal.pose, settings.residuals)
    known = spread_of(lost.record, gain, measurement, from_rest=beginning.from_rest)
    spread = lost.spread(known)
    check_enough_left(lost.record, known, spread, settings.residuals)
    spread[:, ~record.predicted] = np.inf
    data = FitData(
        record=_with_usable_tool(lost.record),
        gain=gain,
        initial_state=beginning.initial_state,
        spread=spread,
        measurement=measurement,
        settings=settings,
        torque_noise=torque_noise,
        from_rest=beginning.from_rest,
        lead_in=beginning.lead_in,
        pose=nominal.pose,
    )
    predictor, theta = around
    predicted = data.predict(predictor, theta[:, None])
    errors = data.weighted(predicted.innovation[:, :, :1])
    return replace(data, nominal_level=float(np.sum(errors**2) / np.isfinite(spread).sum())), predicted


def _with_tool(data: FitData, predictor: Predictor, theta: FloatArray) -> FitData:
    """Transform the tool measurement to the frame of a prediction."""
    record, most = data.record, data.settings.residuals.tool_poses
    if record.tool is None:
        return data
    noise = tracker_noise(record.tool, predictor.robot.tool_noise)
    poses = data.predict(predictor, theta[:, None], pose_samples=np.arange(record.n_samples)).tool_pose
    assert poses is not None
    return replace(data, tool=tool_data(record.tool, poses[:, :, 0], data.counted, record.sample_time, noise, most))


def _with_sensors(data: FitData, nominal: Predictor, predicted: LoopPrediction) -> FitData:
    """Add the further sensors of a log, with warnings of those that are left out."""
    record = data.record
    if not record.sensors:
        return data
    assert predicted.states is not None
    most = data.settings.residuals.sensor_values
    sensors = sensor_data(record, data.gain, data.measurement, data.counted, nominal, predicted.states, most)
    record = replace(record, warnings=(*record.warnings, *sensors.warnings))
    return replace(data, record=record, sensors=sensors if sensors.channels else None)


def _with_initial_state_errors(data: FitData, predictor: Predictor, theta: FloatArray) -> FitData:
    """Add the effect of initial-state errors, for a log that begins at rest."""
    if not data.from_rest:
        return data
    return replace(data, initial_state_errors=initial_state_errors(data, predictor, theta))


def _with_usable_tool(record: Record) -> Record:
    """Leave out a tool measurement of too few poses, with a warning."""
    if record.tool is None:
        return record
    poses = len(usable_poses(record.tool, record.duration)[1])
    if poses >= FEWEST:
        return record
    warning = f"{poses} poses of the tool are within the log, at least {FEWEST} are needed: the tool is left out"
    return replace(record, tool=None, warnings=(*record.warnings, warning))


def _check_bounded(predicted: LoopPrediction, record: Record, robot: Robot) -> None:
    """Refuse a log that the nominal model cannot follow at all, such as that of an unstable loop.

    Joints that lack their rotors are often too light for the torques of a log. Of a robot file that leaves rotors out,
    those that the torques show are given before (`unknown_numbers`).
    """
    farthest = float(np.ptp(record.position, axis=0).max())
    if np.all(np.abs(predicted.innovation[:, :, 0]) <= RUN_AWAY * farthest):
        return
    bare = [name for name, lacks in zip(robot.joint_names, rotor_unknown(robot), strict=True) if lacks]
    lacking = (
        f"robot {robot.name} has no rotor inertia at {', '.join(bare)}, and the torques do not show it, so that bodies "
        "alone may be too light: state 'inertia' of these motors in the robot file, or give a patch with it; else "
    )
    raise InputError(
        f"{record.name}: the prediction of the nominal model diverges from this log, in which motors move by up to "
        f"{farthest:.3g} rad or m; {lacking if bare else ''}check units, signs and order of the motors, and whether "
        "the control loop was stable, or give the log of another run"
    )
