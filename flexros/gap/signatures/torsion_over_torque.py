"""Torsion of a gear in excess of its nominal spring, over the torque: backlash, hysteresis, stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned, thinned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


CLOUD = 1500
"""Number of single samples shown (chosen)."""
BINS = 60
"""Parts of the torque over which torsions are averaged (chosen)."""


class TorsionOverTorque(AbstractSignature):
    """Torsion that the nominal spring does not explain, by the torque through the gear."""

    name: ClassVar[str] = "torsion_over_torque"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Show torsion over torque; None for a rigid gear and where no states were kept."""
        motor, rows = data.motor_of(location), data.rows
        torque_unit, unit = data.units(motor)
        torsion, nominal = data.motion.torsion[rows, motor], data.motion.gear_torque[rows, motor]
        if len(rows) < 2 or not np.isfinite(torsion).any():
            return None
        disturbance = {name: torque[rows, motor] for name, torque in data.gear_disturbance.items()}
        stiffness = float(nominal @ nominal / (nominal @ torsion)) if nominal @ torsion else np.inf
        torque, extra = nominal - disturbance["before"], disturbance["before"] / stiffness
        step = max(1, len(rows) // CLOUD)
        rising = np.gradient(nominal) > 0
        series = {
            "rising torque": Curve(*binned(torque[rising], extra[rising], BINS)),
            "falling torque": Curve(*binned(torque[~rising], extra[~rising], BINS)),
            "single samples": Curve(*thinned(torque[::step], extra[::step]), style="points"),
        }
        if "after" in disturbance:
            series["after"] = Curve(*binned(nominal, disturbance["after"] / stiffness, BINS))
        return Picture(
            title=f"Torsion over transmitted torque, {data.robot.joint_names[motor]}",
            x_label=f"torque through the gear [{torque_unit}]",
            y_label=f"torsion in excess of the nominal spring [{unit}]",
            series=series,
            reading="Backlash is a step at zero torque, hysteresis a loop between rising and falling torque, a "
            "nonlinear spring a curve, a stiffness error a slope. The nominal gear is at zero.",
        )
