"""Disturbance torque over one turn of the rotor: ripple."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 180
"""Parts of a turn over which torques are averaged (chosen)."""


class TorqueOverRotorAngle(AbstractSignature):
    """Mean disturbance torque over one turn of the rotor, forward and backward separately."""

    name: ClassVar[str] = "torque_over_rotor_angle"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Average the disturbance torque over parts of a turn; None where the rotor makes less than one turn."""
        motor = data.motor_of(location)
        torque_unit, _ = data.units(motor)
        angle = data.motion.rotor_angle[data.rows, motor]
        if not len(angle) or np.ptp(angle) < 2 * np.pi:
            return None
        turn, speed = np.mod(angle, 2 * np.pi), data.motion.speed[data.rows, motor]
        series = {}
        for name, torque in data.motor_disturbance(motor).items():
            for direction, inside in (("forward", speed > 0), ("backward", speed < 0)):
                level = torque[inside] - torque[inside].mean() if inside.any() else torque[inside]
                series[f"{name}, {direction}"] = Curve(*binned(turn[inside], level, BINS))
        return Picture(
            title=f"Disturbance torque over one turn of the rotor, {data.robot.joint_names[motor]}",
            x_label="angle of the rotor [rad]",
            y_label=f"disturbance torque without its mean [{torque_unit}]",
            series=series,
            reading="Harmonics of the rotor angle repeat from turn to turn. Those of a torque (cogging) are equal in "
            "both directions, those of an angle are shifted between them. Their number per turn is the order.",
        )
