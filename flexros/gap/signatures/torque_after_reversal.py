"""Missing torque over the way since the last reversal: friction that builds up."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 40
"""Parts of the logarithm of the way over which torques are averaged (chosen)."""


class TorqueAfterReversal(AbstractSignature):
    """Mean torque against the motion by the way since the speed changed its sign."""

    name: ClassVar[str] = "torque_after_reversal"

    def picture(self, evidence: SignatureData, location: str) -> Picture | None:
        """Average the torque over parts of the way; None where the motor never turns round."""
        motor, rows = evidence.motor_of(location), evidence.rows
        torque_unit, unit = evidence.units(motor)
        speed = evidence.motion.speed[:, motor]
        sign = np.sign(speed)
        starts = np.flatnonzero(np.diff(sign) != 0) + 1
        if len(starts) < 2:
            return None
        position = evidence.motion.position[:, motor]
        last = np.searchsorted(starts, rows, side="right") - 1
        since = rows[last >= 0]
        way = np.abs(position[since] - position[starts[last[last >= 0]]])
        moved = way > evidence.observer.noise[motor]
        series = {}
        for name, torque in evidence.lacking(motor).items():
            against = -(torque[last >= 0] * sign[since])[moved]
            place, mean = binned(np.log(way[moved]), against, BINS)
            series[name] = Curve(np.exp(place), mean)
        if not len(series["before"].x):
            return None
        return Picture(
            title=f"Missing torque after reversals, {evidence.robot.joint_names[motor]}",
            x_label=f"way since the last reversal [{unit}]",
            y_label=f"torque against the motion that the model lacks [{torque_unit}]",
            series=series,
            reading="Coulomb friction is there at once; friction of bristles builds up over a way, which is where "
            "the curve rises.",
            log_x=True,
        )
