"""Section: the patch that repairs the model, to be copied."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Listing, Paragraph

if TYPE_CHECKING:
    from flexros.gap.result import DiagnosisResult

_USELESS = 0.1
"""A patch that closes less of the gap than this share is not recommended (chosen)."""


class PatchSection(AbstractSection["DiagnosisResult"]):
    """The text of patch.yaml, and what to do with it."""

    title: ClassVar[str] = "The patch"

    def __init__(self, text: str) -> None:
        """Keep the text.

        Args:
            text: The patch as YAML; empty where nothing was found.
        """
        self._text = text

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return the patch with its commands."""
        if not self._text:
            return ()
        told = (
            "The effects with their fitted numbers on top of the nominal robot. The file patch.yaml is accepted "
            "wherever a robot is: to simulate, to plan the feedforward anew, to diagnose again."
        )
        if result.diagnosis.verdict == "unknown_effect":
            told += " It repairs only a part of the gap, as its cause is not among the known effects."
        if result.diagnosis.verdict == "ambiguous":
            told += " It holds the most probable explanation; a rival that predicts equally well serves as long as the "
            told += "robot moves as in this log."
        closed = result.diagnosis.gap.closed_fraction
        if closed is not None and closed < _USELESS:
            told = (
                "The effects with their fitted numbers. They do not shrink the gap on held-out data: do not use them."
            )
        commands = "flexros gap BAG --model patch.yaml      # a new log against the repaired model\n"
        commands += "flexros run SCENARIO --model patch.yaml  # simulate, with a feedforward that knows the effects\n"
        return (
            Paragraph(told),
            Listing(self._text, "patch.yaml, beside this report."),
            Listing(commands, "What to do with it."),
        )
