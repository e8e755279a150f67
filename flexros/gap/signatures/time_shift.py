"""Time shift of the effective torque relative to the command: delay and lag."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy.signal import csd, welch

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


HIGHEST = 40.0
"""Highest frequency shown [Hz]; above it the disturbance torque is not estimated (chosen)."""
PART = 2.0
"""Length of the parts over which spectra are averaged [s] (chosen)."""
LEAST_POWER = 1e-3
"""Power of the command, relative to its largest, below which nothing is shown (chosen)."""


class TimeShift(AbstractSignature):
    """Phase between the command and the effective torque, expressed as a time."""

    name: ClassVar[str] = "time_shift"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Compute the time shift by frequency; None where the log is too short or the command is zero."""
        motor, rows = data.motor_of(location), data.rows
        T = data.record.sample_time
        length = round(PART / T)
        if len(rows) < 3 * length:
            return None
        command = data.motion.torque[rows, motor]
        frequency, power = welch(command, 1 / T, nperseg=length)
        if not power.max() > 0:
            return None
        shown = (frequency > 1) & (frequency < HIGHEST) & (power > LEAST_POWER * power.max())
        series = {}
        for name, torque in data.motor_disturbance(motor).items():
            _, cross = csd(command, command + torque, 1 / T, nperseg=length)
            shift = -np.angle(cross[shown]) / (2 * np.pi * frequency[shown])
            series[name] = Curve(frequency[shown], 1e3 * shift, style="points")
        return Picture(
            title=f"Time shift of the torque, {data.robot.joint_names[motor]}",
            x_label="frequency [Hz]",
            y_label="delay of the torque relative to the model [ms]",
            series=series,
            reading="A delay shifts all frequencies by the same time, a lag shifts them less towards its corner "
            "frequency. A repaired model is at zero.",
        )
