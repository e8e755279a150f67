"""Effective torque over commanded torque: saturation, gain, bias."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned, thinned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


BINS = 60
"""Parts of the command over which torques are averaged (chosen)."""
CLOUD = 800
"""Number of single samples shown (chosen)."""


class EffectiveTorque(AbstractSignature):
    """Command plus disturbance torque, over the command."""

    name: ClassVar[str] = "effective_torque"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Average the effective torque over parts of the command."""
        motor, rows = data.motor_of(location), data.rows
        unit, _ = data.units(motor)
        command = data.motion.torque[rows, motor]
        if not len(rows) or np.ptp(command) <= 0:
            return None
        ends = np.array([command.min(), command.max()])
        effective = command + data.motor_disturbance(motor)["before"]
        step = max(1, len(rows) // CLOUD)
        return Picture(
            title=f"Effective over commanded torque, {data.robot.joint_names[motor]}",
            x_label=f"torque command [{unit}]",
            y_label=f"effective torque [{unit}]",
            series={
                "mean": Curve(*binned(command, effective, BINS)),
                "as commanded": Curve(ends, ends),
                "single samples": Curve(*thinned(command[::step], effective[::step]), style="points"),
            },
            reading="A gain error changes the slope of the line, a bias shifts it, and saturation flattens its ends.",
        )
