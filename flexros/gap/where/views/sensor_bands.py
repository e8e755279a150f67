"""Excess of further sensors by octave band and regime."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.where.channel import sampled_channel
from flexros.gap.where.views.position_bands import AbstractBands
from flexros.record.further_sensors import SENSOR_QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Self

    from flexros.gap.where.prediction_errors import PredictionErrors

LEAST_VALUES = 100
"""Values below which no gap is located (chosen)."""


@dataclass(frozen=True, eq=False)
class SensorBands(AbstractBands):
    """Excess of link-side encoders, joint torque sensors, accelerometer and gyroscope, by octave band and regime.

    Attributes:
        quantity: What the sensor measures.
    """

    name: ClassVar[str] = "sensor_bands"
    rank: ClassVar[int] = 6
    words: ClassVar[Mapping[str, str]] = MappingProxyType(
        {quantity: f"excess of the {quantity}" for quantity in SENSOR_QUANTITIES}
    )

    quantity: str

    @property
    def signal(self) -> str:
        """What the sensor measures."""
        return self.quantity

    @classmethod
    def of_log(cls, errors: PredictionErrors) -> Sequence[Self]:
        """Prepare the view of each channel; none where there are no further sensors."""
        found = []
        for one in errors.sensors:
            if np.count_nonzero(one.valid) < LEAST_VALUES:
                continue
            sensor, motors = one.sensor, errors.motors
            joint = "tool" if sensor.of_tool else sensor.place
            own = [motor for motor in motors if motor.joint == sensor.place]
            own = own or list(motors)  # a sensor of the tool, or of a joint whose motion is prescribed
            values = (sensor.time, one.errors, one.valid)
            found.append(cls(sampled_channel(joint, *values, own, errors.record, errors.settings), sensor.quantity))
        return found
