"""Disturbance torque over the speed of a motor: friction."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned, thinned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 60
"""Parts of the speed over which torques are averaged; they are narrower near standstill (chosen)."""
CLOUD = 800
"""Number of single samples shown (chosen)."""


class TorqueOverSpeed(AbstractSignature):
    """Mean disturbance torque by speed: a step at zero is Coulomb friction, a slope viscous, a hump Stribeck."""

    name: ClassVar[str] = "torque_over_speed"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Average the disturbance torque over parts of the speed."""
        motor = data.motor_of(location)
        torque_unit, unit = data.units(motor)
        speed = data.motion.speed[data.rows, motor]
        root = np.sign(speed) * np.sqrt(np.abs(speed))
        series = {}
        for name, torque in data.motor_disturbance(motor).items():
            mean_root, mean = binned(root, torque, BINS)
            series[name] = Curve(np.sign(mean_root) * mean_root**2, mean)
        step = max(1, len(speed) // CLOUD)
        series["single samples, before"] = Curve(
            *thinned(speed[::step], data.motor_disturbance(motor)["before"][::step]), style="points"
        )
        return Picture(
            title=f"Disturbance torque over speed, {data.robot.joint_names[motor]}",
            x_label=f"speed of the motor [{unit}/s]",
            y_label=f"disturbance torque [{torque_unit}]",
            series=series,
            reading="Friction is negative at positive and positive at negative speed: a step at standstill is "
            "Coulomb friction, a slope viscous friction, a peak near standstill Stribeck friction. A shift of the "
            "whole curve is a bias. A repaired model is at zero.",
        )
