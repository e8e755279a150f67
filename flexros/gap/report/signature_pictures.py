"""Pictures of the signature of an effect."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.analysis.report.base import Picture
    from flexros.gap.result import Candidate, DiagnosisResult


def signature_pictures(one: Candidate, result: DiagnosisResult) -> tuple[Picture, ...]:
    """Draw what an effect leaves in the log.

    Args:
        one: The effect.
        result: What was found.

    Returns:
        Its pictures.
    """
    del one, result
    return ()
