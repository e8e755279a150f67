"""Missing torque over one turn of the rotor: ripple."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 180
"""Parts of a turn over which torques are averaged (chosen)."""


class TorqueOverRotorAngle(AbstractSignature):
    """Mean missing torque over one turn of the rotor, forward and backward separately."""

    name: ClassVar[str] = "torque_over_rotor_angle"

    def picture(self, evidence: SignatureData, location: str) -> Picture | None:
        """Average the missing torque over parts of a turn; None where the rotor makes less than one turn."""
        motor = evidence.motor_of(location)
        torque_unit, _ = evidence.units(motor)
        angle = evidence.motion.rotor_angle[evidence.rows, motor]
        if not len(angle) or np.ptp(angle) < 2 * np.pi:
            return None
        turn, speed = np.mod(angle, 2 * np.pi), evidence.motion.speed[evidence.rows, motor]
        series = {}
        for name, torque in evidence.lacking(motor).items():
            for way, inside in (("forward", speed > 0), ("backward", speed < 0)):
                level = torque[inside] - torque[inside].mean() if inside.any() else torque[inside]
                series[f"{name}, {way}"] = Curve(*binned(turn[inside], level, BINS))
        return Picture(
            title=f"Missing torque over one turn of the rotor, {evidence.robot.joint_names[motor]}",
            x_label="angle of the rotor [rad]",
            y_label=f"torque that the model lacks, without its mean [{torque_unit}]",
            series=series,
            reading="Harmonics of the rotor angle repeat from turn to turn: equal in both directions for cogging, "
            "shifted between them where they enter as an angle; their number per turn is the order.",
        )
