"""Disturbance torque over the acceleration of a motor: inertia, payload, gain."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 50
"""Parts of the acceleration over which torques are averaged (chosen)."""


class TorqueOverAcceleration(AbstractSignature):
    """Mean disturbance torque by acceleration."""

    name: ClassVar[str] = "torque_over_acceleration"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Average the disturbance torque over parts of the acceleration."""
        motor, rows = data.motor_of(location), data.rows
        torque_unit, unit = data.units(motor)
        acceleration = data.motion.acceleration[rows, motor]
        if not len(rows) or np.ptp(acceleration) <= 0:
            return None
        series = {
            name: Curve(*binned(acceleration, torque, BINS)) for name, torque in data.motor_disturbance(motor).items()
        }
        return Picture(
            title=f"Disturbance torque over acceleration, {data.robot.joint_names[motor]}",
            x_label=f"acceleration of the motor [{unit}/s²]",
            y_label=f"disturbance torque [{torque_unit}]",
            series=series,
            reading="A straight line through zero is an inertia that is too small (falling) or too large (rising) in "
            "the model. An error of the torque gain looks the same except for springs and gravity.",
        )
