"""Disturbance torque over the position of a motor: gravity and bias."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 80
"""Parts of the position over which torques are averaged (chosen)."""


class TorqueOverPosition(AbstractSignature):
    """Mean disturbance torque by position, forward and backward separately."""

    name: ClassVar[str] = "torque_over_position"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Average the disturbance torque over parts of the position."""
        motor = data.motor_of(location)
        torque_unit, unit = data.units(motor)
        position = data.motion.position[data.rows, motor]
        speed = data.motion.speed[data.rows, motor]
        series = {}
        for name, torque in data.motor_disturbance(motor).items():
            for direction, inside in (("forward", speed > 0), ("backward", speed < 0)):
                series[f"{name}, {direction}"] = Curve(*binned(position[inside], torque[inside], BINS))
        if not any(len(curve.x) for curve in series.values()):
            return None
        return Picture(
            title=f"Disturbance torque over position, {data.robot.joint_names[motor]}",
            x_label=f"position of the motor [{unit}]",
            y_label=f"disturbance torque [{torque_unit}]",
            series=series,
            reading="A gravity error is a sine of the position, equal in both directions. A bias is constant. Friction "
            "is the distance between the two directions.",
        )
