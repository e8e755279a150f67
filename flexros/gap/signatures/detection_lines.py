"""Prediction errors at excited and at detection lines of a multisine: linear or nonlinear."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, thinned
from flexros.gap.where.views.detection_lines import KINDS, line_levels

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


class DetectionLines(AbstractSignature):
    """Prediction errors in standard deviations of noise, line by line, in the multisine with the largest errors."""

    name: ClassVar[str] = "detection_lines"

    def picture(self, evidence: SignatureData, location: str) -> Picture | None:
        """Show the lines; None where no periodic part of the log is known."""
        motor, record = evidence.motor_of(location), evidence.record
        errors = evidence.before.innovations
        every = [line_levels(errors, record.valid, part, record.sample_time) for part in record.parts]
        known = [levels for levels in every if levels is not None]
        if not known:
            return None
        levels = max(known, key=lambda one: float((one.power - one.noise)[:, motor].sum()))
        distance = levels.distance[:, motor]
        series = {}
        for number, name in enumerate(KINDS):
            mine = levels.kind == number
            if mine.any():
                series[name] = Curve(*thinned(levels.frequency[mine], distance[mine]), style="points")
        return Picture(
            title=f"Prediction errors by lines of a multisine, {evidence.robot.joint_names[motor]}",
            x_label="frequency [Hz]",
            y_label="error [standard deviations of noise]",
            series=series,
            reading="Where only excited lines rise above about 3 the gap is linear; a symmetric nonlinearity raises "
            "odd detection lines as well, one with a bias the even ones.",
            log_x=True,
            log_y=True,
        )
