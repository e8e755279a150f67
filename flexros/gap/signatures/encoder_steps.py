"""Steps between successive encoder values: quantization."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 400
"""Columns of the histogram (chosen)."""


class EncoderSteps(AbstractSignature):
    """Histogram of the differences between successive encoder values."""

    name: ClassVar[str] = "encoder_steps"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Count the differences, without the largest ones."""
        motor = data.motor_of(location)
        _, unit = data.units(motor)
        step = np.diff(data.record.position[:, motor])
        step = step[data.record.valid[1:] & data.record.valid[:-1]]
        reach = float(np.quantile(np.abs(step), 0.6)) if len(step) else 0.0
        if reach <= 0:
            return None
        count, edges = np.histogram(step, BINS, range=(-reach, reach))
        return Picture(
            title=f"Steps of the encoder, {data.robot.joint_names[motor]}",
            x_label=f"difference of two successive values [{unit}]",
            y_label="number of samples [1]",
            series={"log": Curve((edges[1:] + edges[:-1]) / 2, count.astype(float), style="bars")},
            reading="A quantized encoder shows only multiples of its step; noise alone gives a smooth distribution.",
        )
