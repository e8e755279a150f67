"""Encoders that round: which of them a model does not know of, and its prediction errors over a floor without that."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.effects import RobotWithEffects
    from flexros.gap.held_out.prediction_gap import AheadErrors
    from flexros.gap.noise.weights import Measurement
    from flexros.gap.residuals.fit_data import FitData
    from flexros.record.quantization import Quantization


def unknown_rounding(model: RobotWithEffects, measurement: Measurement) -> tuple[Quantization, ...]:
    """List the encoders whose rounding matters and is not in the model.

    Args:
        model: The model.
        measurement: Noise and rounding of the encoders.
    """
    known = {law.location for law in model.laws if law.effect.as_noise}
    names = model.robot.joint_names
    return tuple(one for one in measurement.quantizations if names[one.motor] not in known)


def over_expected_floor(errors: AheadErrors, model: RobotWithEffects, data: FitData) -> AheadErrors:
    """Refer prediction errors to the floor that a model expects: that of encoders that round only where it says so.

    Rounding that the model does not know of is a gap then, as any other effect.

    Args:
        errors: Errors of predictions over the floor of the log, rounding included.
        model: The model.
        data: The log.
    """
    unknown = unknown_rounding(model, data.measurement)
    if not unknown:
        return errors
    expected = np.array(data.gain.noise)
    for one in unknown:
        expected[one.motor] = model.robot.encoder_noise[one.motor]
    return errors.over(np.sqrt(errors.floor**2 - data.gain.noise**2 + expected**2))
