"""Missing torque over the position of a motor: gravity and bias."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 80
"""Parts of the position over which torques are averaged (chosen)."""


class TorqueOverPosition(AbstractSignature):
    """Mean missing torque by position, forward and backward separately."""

    name: ClassVar[str] = "torque_over_position"

    def picture(self, evidence: SignatureData, location: str) -> Picture | None:
        """Average the missing torque over parts of the position."""
        motor = evidence.motor_of(location)
        torque_unit, unit = evidence.units(motor)
        position = evidence.motion.position[evidence.rows, motor]
        speed = evidence.motion.speed[evidence.rows, motor]
        series = {}
        for name, torque in evidence.lacking(motor).items():
            for way, inside in (("forward", speed > 0), ("backward", speed < 0)):
                series[f"{name}, {way}"] = Curve(*binned(position[inside], torque[inside], BINS))
        if not any(len(curve.x) for curve in series.values()):
            return None
        return Picture(
            title=f"Missing torque over position, {evidence.robot.joint_names[motor]}",
            x_label=f"position of the motor [{unit}]",
            y_label=f"torque that the model lacks [{torque_unit}]",
            series=series,
            reading="A gravity error is a sine of the position, equal in both directions; a bias is constant; friction "
            "is the distance between the two directions.",
        )
