"""Disturbance torque against the motion over time: drift."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 60
"""Parts of the time over which torques are averaged (chosen)."""


class FrictionOverTime(AbstractSignature):
    """Mean torque against the motion by time."""

    name: ClassVar[str] = "friction_over_time"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Average the torque against the motion over parts of the time, without rests."""
        motor, rows = data.motor_of(location), data.rows
        torque_unit, _ = data.units(motor)
        speed = data.motion.speed[rows, motor]
        moving = np.abs(speed) > 0.02 * np.abs(speed).max(initial=0.0)
        if not moving.any():
            return None
        time = rows * data.record.sample_time
        series = {
            name: Curve(*binned(time[moving], -(torque * np.sign(speed))[moving], BINS))
            for name, torque in data.motor_disturbance(motor).items()
        }
        return Picture(
            title=f"Friction over time, {data.robot.joint_names[motor]}",
            x_label="time [s]",
            y_label=f"disturbance torque against the motion [{torque_unit}]",
            series=series,
            reading="A constant level is friction. A level that falls or rises during the log is friction drift, for "
            "example of warming grease.",
        )
