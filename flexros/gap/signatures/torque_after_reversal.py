"""Disturbance torque over the travel since the last reversal: friction that builds up."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 40
"""Parts of the logarithm of the travel over which torques are averaged (chosen)."""


class TorqueAfterReversal(AbstractSignature):
    """Mean torque against the motion by the travel since the last change of sign of the speed."""

    name: ClassVar[str] = "torque_after_reversal"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Average the torque over parts of the travel; None where the motor never reverses."""
        motor, rows = data.motor_of(location), data.rows
        torque_unit, unit = data.units(motor)
        speed = data.motion.speed[:, motor]
        sign = np.sign(speed)
        starts = np.flatnonzero(np.diff(sign) != 0) + 1
        if len(starts) < 2:
            return None
        position = data.motion.position[:, motor]
        last = np.searchsorted(starts, rows, side="right") - 1
        since = rows[last >= 0]
        travel = np.abs(position[since] - position[starts[last[last >= 0]]])
        moved = travel > data.observer.noise[motor]
        series = {}
        for name, torque in data.motor_disturbance(motor).items():
            against = -(torque[last >= 0] * sign[since])[moved]
            log_travel, mean = binned(np.log(travel[moved]), against, BINS)
            series[name] = Curve(np.exp(log_travel), mean)
        return Picture(
            title=f"Disturbance torque after reversals, {data.robot.joint_names[motor]}",
            x_label=f"travel since the last reversal [{unit}]",
            y_label=f"disturbance torque against the motion [{torque_unit}]",
            series=series,
            reading="Coulomb friction acts at once. Presliding friction builds up over a distance, over which the "
            "curve rises.",
            log_x=True,
        )
