"""Disturbance torque over time: what drifts without the motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 60
"""Parts of the time over which torques are averaged (chosen)."""


class TorqueOverTime(AbstractSignature):
    """Mean disturbance torque by time."""

    name: ClassVar[str] = "torque_over_time"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Average the disturbance torque over parts of the time."""
        motor, rows = data.motor_of(location), data.rows
        torque_unit, _ = data.units(motor)
        time: FloatArray = np.asarray(rows * data.record.sample_time, dtype=float)
        if not len(time):
            return None
        series = {name: Curve(*binned(time, torque, BINS)) for name, torque in data.motor_disturbance(motor).items()}
        return Picture(
            title=f"Disturbance torque over time, {data.robot.joint_names[motor]}",
            x_label="time [s]",
            y_label=f"disturbance torque [{torque_unit}]",
            series=series,
            reading="Torques that depend on the motion swing with it. A mean that changes during the log is a drift of "
            "load, cable or sensor; a constant one is a bias.",
        )
