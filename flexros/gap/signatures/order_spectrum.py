"""Order spectrum of the disturbance torque: harmonics of the rotor angle."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, thinned
from flexros.gap.where.views.order_spectrum import OrderGrid

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


HIGHEST = 60.0
"""Highest order shown [periods per turn] (chosen)."""


class OrderSpectrum(AbstractSignature):
    """Amplitude of the disturbance torque by order, over motions at several speeds."""

    name: ClassVar[str] = "order_spectrum"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Transform over the rotor angle; None where the rotor turns too little."""
        motor = data.motor_of(location)
        unit, _ = data.units(motor)
        inside = np.zeros(data.record.n_samples, dtype=bool)
        inside[data.rows] = True
        motion = data.motion
        grid = OrderGrid.of(motion.rotor_angle[:, motor], motion.speed[:, motor], inside, HIGHEST)
        if not len(grid.orders):
            return None
        samples = sum(len(rows) for rows in grid.groups)
        series = {}
        for name, torque in (("before", data.disturbance), ("after", data.disturbance_after)):
            if torque is not None:
                power = grid.power(torque[:, motor]).sum(axis=0)
                series[name] = Curve(*thinned(grid.orders, np.sqrt(2 * power / samples)))
        return Picture(
            title=f"Order spectrum of the disturbance torque, {data.robot.joint_names[motor]}",
            x_label="order [periods per turn of the rotor]",
            y_label=f"amplitude of the disturbance torque [{unit}]",
            series=series,
            reading="A peak is a harmonic of the rotor angle at all speeds. A repaired model removes it.",
        )
