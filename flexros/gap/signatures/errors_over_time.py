"""Prediction errors over time, before and after the repair."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, thinned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


class ErrorsOverTime(AbstractSignature):
    """Prediction errors in units of their noise; they tell of every effect."""

    name: ClassVar[str] = "errors_over_time"
    effects: ClassVar[tuple[str, ...]] = ()

    def picture(self, evidence: SignatureData, location: str) -> Picture | None:
        """Show the errors of the motor."""
        motor = evidence.motor_of(location)
        time = np.asarray(np.arange(evidence.record.n_samples) * evidence.record.sample_time, dtype=float)
        series = {}
        for name, prediction in (("before", evidence.before), ("after", evidence.after)):
            if prediction is not None:
                scaled = prediction.innovations[:, motor] / prediction.sd[motor]
                series[name] = Curve(*thinned(time, np.asarray(np.where(evidence.record.valid, scaled, 0.0))))
        return Picture(
            title=f"Prediction errors, {evidence.robot.joint_names[motor]}",
            x_label="time [s]",
            y_label="prediction error [standard deviations of its noise]",
            series=series,
            reading="Without a gap nearly all errors lie between -3 and 3; what sticks out says when the gap acts.",
        )
