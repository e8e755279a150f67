"""Section: measured responses with their uncertainty, and the model before and after (Paper A, figure 8)."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.analysis.report.base import Block, Picture
from flexros.analysis.report.response_picture import ModelCurve, response_picture
from flexros.identify.graybox.response_noise import response_noise
from flexros.identify.report.base import AbstractIdentificationSection

if TYPE_CHECKING:
    from flexros.identify.report.result import IdentificationResult

BEFORE, AFTER = "#e69f00", "#d55e00"


class ResponseSection(AbstractIdentificationSection):
    """One panel per motor pair; menus choose position, and magnitude or phase."""

    title: ClassVar[str] = "Frequency responses"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return the picture."""
        nominal = result.problem.model_at(result.nominal).response(result.nominal)
        models = (
            ModelCurve("nominal", "nominal model", BEFORE, 1.2, tuple(nominal)),
            ModelCurve("identified", "identified model", AFTER, 2, tuple(result.residuals.response)),
        )
        return (Picture(response_picture(result.problem.responses, models), _caption(result)),)


def _caption(result: IdentificationResult) -> str:
    bands = [response_noise(response) for response in result.problem.responses]
    band = "; shaded: one standard deviation of the measured response" if any(bands) else ""
    return (
        "Response of the motor accelerations to the motor torques, columns: input, rows: output. Points: measured"
        f"{band}; thin: nominal model, thick: identified model. The menus choose position, and magnitude or phase."
    )
