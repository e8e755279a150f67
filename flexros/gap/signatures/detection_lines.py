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

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Show the lines; None where no periodic part of the log is known."""
        motor, record = data.motor_of(location), data.record
        errors = data.before.innovations
        every = [line_levels(errors, record.valid, part, record.sample_time) for part in record.parts]
        periodic = [levels for levels in every if levels is not None]
        if not periodic:
            return None
        levels = max(periodic, key=lambda part: float((part.power - part.noise)[:, motor].sum()))
        distance = levels.distance[:, motor]
        series = {}
        for number, name in enumerate(KINDS):
            rows = levels.kind == number
            if rows.any():
                series[name] = Curve(*thinned(levels.frequency[rows], distance[rows]), style="points")
        return Picture(
            title=f"Prediction errors by lines of a multisine, {data.robot.joint_names[motor]}",
            x_label="frequency [Hz]",
            y_label="error [standard deviations of noise]",
            series=series,
            reading="Where only excited lines exceed about 3, the gap is linear. A symmetric nonlinearity also raises "
            "odd detection lines, one with a bias even detection lines.",
            log_x=True,
            log_y=True,
        )
