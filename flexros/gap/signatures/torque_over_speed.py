"""Missing torque over the speed of a motor: friction."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned, thinned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 60
"""Parts of the speed over which torques are averaged; they are narrower near standstill (chosen)."""
CLOUD = 800
"""Single samples that are shown (chosen)."""


class TorqueOverSpeed(AbstractSignature):
    """Mean missing torque by speed: a step at zero is Coulomb friction, a slope viscous, a hump Stribeck friction."""

    name: ClassVar[str] = "torque_over_speed"

    def picture(self, evidence: SignatureData, location: str) -> Picture | None:
        """Average the missing torque over parts of the speed."""
        motor = evidence.motor_of(location)
        torque_unit, unit = evidence.units(motor)
        speed = evidence.motion.speed[evidence.rows, motor]
        root = np.sign(speed) * np.sqrt(np.abs(speed))
        series = {}
        for name, torque in evidence.lacking(motor).items():
            place, mean = binned(root, torque, BINS)
            series[name] = Curve(np.sign(place) * place**2, mean)
        step = max(1, len(speed) // CLOUD)
        series["single samples, before"] = Curve(
            *thinned(speed[::step], evidence.lacking(motor)["before"][::step]), style="points"
        )
        if not len(series["before"].x):
            return None
        return Picture(
            title=f"Missing torque over speed, {evidence.robot.joint_names[motor]}",
            x_label=f"speed of the motor [{unit}/s]",
            y_label=f"torque that the model lacks [{torque_unit}]",
            series=series,
            reading="Friction is below zero at positive and above zero at negative speed: a step at standstill is "
            "Coulomb friction, a slope viscous friction, a peak near standstill Stribeck friction, a shift of "
            "everything a bias; a repaired model is at zero.",
        )
