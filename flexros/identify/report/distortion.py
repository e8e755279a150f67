"""Section: levels of noise, nonlinear distortions and time variation in the measured outputs."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.identify.report.distortion_levels import distortion_blocks
from flexros.report.base import AbstractSection

if TYPE_CHECKING:
    from flexros.identify.graybox.result import IdentificationResult
    from flexros.report.base import Block


class DistortionSection(AbstractSection["IdentificationResult"]):
    """One panel per motor, a menu of positions, and a table of medians."""

    title: ClassVar[str] = "Noise and nonlinear distortions"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return sentence, picture and table; nothing where the responses have no levels."""
        return distortion_blocks(result.problem.responses)
