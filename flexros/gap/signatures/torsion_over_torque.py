"""Torsion of a gear over the torque that it transmits: backlash, hysteresis, stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, binned, thinned

if TYPE_CHECKING:
    from flexros.gap.signatures.evidence import Evidence


CLOUD = 1500
"""Single samples that are shown (chosen)."""
BINS = 60
"""Parts of the torque over which torsions are averaged (chosen)."""


class TorsionOverTorque(AbstractSignature):
    """Torsion from the states over transmitted torque, corrected by what is missing at the motor."""

    name: ClassVar[str] = "torsion_over_torque"
    effects: ClassVar[tuple[str, ...]] = ("backlash", "hysteresis", "nonlinear_stiffness", "stiffness_error")

    def picture(self, evidence: Evidence, location: str) -> Picture | None:
        """Show torsion over torque; None for a rigid gear and where no states were kept."""
        motor, rows = evidence.motor_of(location), evidence.rows
        torque_unit, unit = evidence.units(motor)
        torsion, nominal = evidence.motion.torsion[rows, motor], evidence.motion.gear_torque[rows, motor]
        if not len(rows) or not np.isfinite(torsion).any():
            return None
        # what the motor lacks the gear has given it less
        torque = nominal - evidence.lacking(motor)["before"]
        step = max(1, len(rows) // CLOUD)
        ends = np.array([nominal.min(), nominal.max()])
        stiffness = float(nominal @ nominal / (nominal @ torsion)) if nominal @ torsion else np.inf
        rising = np.gradient(nominal) > 0
        series = {
            "rising torque": Curve(*binned(torque[rising], torsion[rising], BINS)),
            "falling torque": Curve(*binned(torque[~rising], torsion[~rising], BINS)),
            "nominal spring": Curve(ends, ends / stiffness),
            "single samples": Curve(*thinned(torque[::step], torsion[::step]), style="points"),
        }
        return Picture(
            title=f"Torsion over transmitted torque, {evidence.robot.joint_names[motor]}",
            x_label=f"torque through the gear [{torque_unit}]",
            y_label=f"torsion of the gear [{unit}]",
            series=series,
            reading="Backlash is a jump of the torsion at zero torque, hysteresis a loop between rising and falling "
            "torque, a nonlinear spring a bend, and a wrong stiffness another slope than that of the nominal spring.",
        )
