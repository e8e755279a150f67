"""Further sensors that contradict the model: a wrong sign, unit or joint is no gap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.residuals.sensor_channel import SensorChannel

SEEN = 5.0
"""Extent of a signal over its noise from which it is compared with the model [1] (chosen)."""
ALIKE = 0.5
"""Correlation with the prediction from which a sensor measures what the model predicts [1] (chosen)."""
FACTOR = 3.0
"""Factor between measurement and prediction above which a unit is wrong, not the model [1] (chosen)."""


@dataclass(frozen=True)
class SensorDoubt:
    """What is doubtful of a sensor.

    Attributes:
        text: The sentence.
        contradicts: Whether the sensor cannot measure what its name says, so that it is left out.
    """

    text: str
    contradicts: bool


def doubt_of(channel: SensorChannel, predicted: FloatArray, noise: float) -> SensorDoubt | None:
    """Compare a sensor with what the nominal model predicts.

    Args:
        channel: The sensor.
        predicted: Prediction of the nominal model, shape (m,).
        noise: Standard deviation of its noise.

    Returns:
        What is doubtful; None where nothing is.
    """
    used = channel.used
    link, motor = channel.sensor.values, channel.sensor.motor
    if motor is None:
        pairs = [(channel.measured, predicted)]
    else:  # a link of the wrong unit is seen in its position, one of the wrong sign in its deflection
        deflection = predicted if channel.deflection else predicted - motor
        pairs = [(link, motor + deflection), (link - motor, deflection)]
    found = [_compared(channel, measured[used], expected[used], noise) for measured, expected in pairs]
    return next((one for one in found if one is not None), None)


def _compared(channel: SensorChannel, measured: FloatArray, predicted: FloatArray, noise: float) -> SensorDoubt | None:
    name = channel.sensor.name
    own, expected = measured - measured.mean(), predicted - predicted.mean()
    extents = float(np.std(own)), float(np.std(expected))
    if max(extents) < SEEN * noise:
        return None
    correlation = float(np.mean(own * expected)) / max(extents[0] * extents[1], 1e-300)
    factor = extents[0] / max(extents[1], 1e-300)
    if correlation < -ALIKE:
        return SensorDoubt(
            f"{name} is opposite to what the nominal model predicts from the motors, so it is left out; correct its "
            "sign (sign: -1 in the mapping)",
            True,
        )
    if correlation > ALIKE and not 1 / FACTOR < factor < FACTOR:
        return SensorDoubt(
            f"{name} is {factor:.3g} times what the nominal model predicts from the motors, so it is left out; check "
            "its unit",
            True,
        )
    if correlation <= ALIKE:
        return SensorDoubt(
            f"{name} hardly follows what the nominal model predicts from the motors (correlation {correlation:.2f}); "
            "check its joint, sign and clock, or the model is far off there",
            False,
        )
    return None
