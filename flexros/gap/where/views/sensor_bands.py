"""Excess of further sensors by octave band and regime."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.where.bands import OctaveBands, fast_length
from flexros.gap.where.channel import Channel
from flexros.gap.where.views.position_bands import AbstractBands
from flexros.gap.where.views.tool_bands import REGIMES_OF_TOOL
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
        record, motors = errors.record, errors.motors
        found = []
        for one in errors.sensors:
            time = one.sensor.time
            if np.count_nonzero(one.valid) < LEAST_VALUES:
                continue
            sample_time = float(time[-1] - time[0]) / (len(time) - 1)
            bands = OctaveBands.of(fast_length(len(time)), sample_time, errors.settings.lowest_hz)
            n, kept = motors[0].bands.n_samples, slice(-bands.n_samples, None)
            rows = np.clip(np.round(time[kept] / record.sample_time).astype(int) - (record.n_samples - n), 0, n - 1)
            own = [channel for channel in motors if channel.joint == one.sensor.place]
            own = own or list(motors)  # a sensor of the tool, or of a joint whose motion is prescribed
            masks = {}
            for name in REGIMES_OF_TOOL:
                of_motors = [channel.masks[channel.regimes.index(name)][rows] > 0 for channel in own]
                masks[name] = np.all(of_motors, axis=0) if name == "standstill" else np.any(of_motors, axis=0)
            channel = Channel(
                "tool" if one.sensor.of_tool else one.sensor.place,
                one.errors[kept],
                bands,
                masks,
                one.valid[kept],
                np.ones(2),
                errors.settings,
                estimate_level=True,
            )
            found.append(cls(channel, one.sensor.quantity))
        return found
