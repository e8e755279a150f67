"""Torsion of a gear beyond its nominal spring, over the torque: backlash, hysteresis, stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned, thinned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


CLOUD = 1500
"""Single samples that are shown (chosen)."""
BINS = 60
"""Parts of the torque over which torsions are averaged (chosen)."""


class TorsionOverTorque(AbstractSignature):
    """Torsion that the nominal spring does not explain, by the torque through the gear."""

    name: ClassVar[str] = "torsion_over_torque"

    def picture(self, evidence: SignatureData, location: str) -> Picture | None:
        """Show torsion over torque; None for a rigid gear and where no states were kept."""
        motor, rows = evidence.motor_of(location), evidence.rows
        torque_unit, unit = evidence.units(motor)
        torsion, nominal = evidence.motion.torsion[rows, motor], evidence.motion.gear_torque[rows, motor]
        if not len(rows) or not np.isfinite(torsion).any():
            return None
        missing = {name: torque[rows, motor] for name, torque in evidence.missing_in_gears.items()}
        stiffness = float(nominal @ nominal / (nominal @ torsion)) if nominal @ torsion else np.inf
        torque, extra = nominal - missing["before"], missing["before"] / stiffness
        step = max(1, len(rows) // CLOUD)
        rising = np.gradient(nominal) > 0
        series = {
            "rising torque": Curve(*binned(torque[rising], extra[rising], BINS)),
            "falling torque": Curve(*binned(torque[~rising], extra[~rising], BINS)),
            "single samples": Curve(*thinned(torque[::step], extra[::step]), style="points"),
        }
        if "after" in missing:
            series["after"] = Curve(*binned(nominal, missing["after"] / stiffness, BINS))
        return Picture(
            title=f"Torsion over transmitted torque, {evidence.robot.joint_names[motor]}",
            x_label=f"torque through the gear [{torque_unit}]",
            y_label=f"torsion beyond that of the nominal spring [{unit}]",
            series=series,
            reading="Backlash is a step at zero torque, hysteresis a loop between rising and falling torque, a "
            "nonlinear spring a curve, a wrong stiffness a slope; the nominal gear is at zero.",
        )
