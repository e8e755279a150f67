"""What the floor of a gap holds beside noise: torques within their tolerance, coarse encoders."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.held_out.errors_ahead import RUN_AWAY, AheadErrors, signed_errors_ahead

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.noise.weights import Measurement
    from flexros.gap.residuals.fit_data import FitData
    from flexros.record.quantization import Quantization
    from flexros.record.record import Record
    from flexros.robot import Robot


def tolerance_floor(fit: CandidateFit, held: FitData) -> float | None:
    """Return the gap E of a log whose torques are off by their tolerance; None where they are exact.

    The floor holds the tolerance t as white torque. An error of a real torque, by a torque constant or friction of
    slightly other form, lasts: then predictions stray farther. Here the torque of each motor deviates from its mean by
    the factor 1 + t, one motor after the other, with the same rms t:

        E = 1 + sum over motors of mean((prediction with its torque off - prediction)^2 / floor^2).

    Numbers of the robot with a tolerance are fitted, so that they leave nothing.

    Args:
        fit: The model.
        held: The log.
    """
    share, record = held.measurement.signal_tolerance, held.record
    if not share:
        return None
    spacing, theta = held.settings.prediction_gap.spacing, fit.theta[:, None]
    (as_recorded,) = signed_errors_ahead(fit.predictor, theta, held, spacing)
    total = 1.0
    for motor in np.flatnonzero(record.predicted).tolist():
        change = np.zeros_like(record.torque)
        change[:, motor] = share * (record.torque[:, motor] - record.torque[:, motor].mean())
        off = replace(held, record=_with_torque(record, fit.predictor.robot, change))
        (errors,) = signed_errors_ahead(fit.predictor, theta, off, spacing)
        strayed = np.clip(errors.errors - as_recorded.errors, -RUN_AWAY, RUN_AWAY)
        total += float(np.nanmean(strayed**2))
    return total


def _with_torque(record: Record, robot: Robot, change: FloatArray) -> Record:
    """Add torques to those of a log [Nm or N], shape (n, M); to the positions of servos what causes such torques."""
    if record.command is None:
        return replace(record, torque=record.torque + change)
    stiffness = [robot.parameters[f"{name}.servo_stiffness"].value for name in robot.joint_names]
    return replace(record, command=record.command + change / np.array(stiffness))


def unknown_rounding(model: RobotWithEffects, measurement: Measurement) -> tuple[Quantization, ...]:
    """List the encoders whose quantization is coarse and not in the model."""
    known = {law.location for law in model.laws if law.effect.as_noise}
    names = model.robot.joint_names
    return tuple(one for one in measurement.quantizations if one.coarse and names[one.motor] not in known)


def over_expected_floor(errors: AheadErrors, model: RobotWithEffects, data: FitData) -> AheadErrors:
    """Refer prediction errors to the floor that a model expects, so that quantization that it lacks is a gap.

    Args:
        errors: Prediction errors over the floor of the log, quantization included.
        model: The model.
        data: The log.
    """
    unknown = unknown_rounding(model, data.measurement)
    if not unknown:
        return errors
    expected = np.array(data.measurement.deviation)
    for encoder in unknown:
        expected[encoder.motor] = model.robot.encoder_noise[encoder.motor]
    more = np.zeros_like(errors.floor)
    added = (expected**2 - data.measurement.deviation**2)[data.record.predicted]
    more[: len(added)] = added
    return errors.over(np.sqrt(errors.floor**2 + more))
