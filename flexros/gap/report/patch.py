"""Section: the patch that repairs the model, to be copied."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Listing, Paragraph

if TYPE_CHECKING:
    from flexros.gap.result import DiagnosisResult

_USELESS = 0.1
"""A patch that closes less of the gap than this share is not recommended (chosen)."""


class PatchSection(AbstractSection["DiagnosisResult"]):
    """The text of patch.yaml and the commands that use it."""

    title: ClassVar[str] = "The patch"

    def __init__(self, text: str) -> None:
        """Take the patch as YAML, empty where no effect was found."""
        self._text = text

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return the patch with its commands."""
        if not self._text:
            return ()
        text = (
            "The effects with their fitted parameters on top of the nominal robot. The file patch.yaml is accepted "
            "wherever a robot is: for simulation, feedforward or another diagnosis."
        )
        if result.diagnosis.verdict == "unknown_effect":
            text += " It repairs only a part of the gap, whose cause is not among the known effects."
        if result.diagnosis.verdict == "partly_explained":
            text += " It repairs a part of the gap; the budget says how much is left, and where."
        if result.diagnosis.verdict == "ambiguous":
            text += (
                " It holds the most probable explanation, which predicts motions like those of this log as well as its "
            )
            text += "rivals."
        closed = result.diagnosis.gap.closed_fraction
        if closed is not None and closed < _USELESS:
            text = "The effects with their fitted parameters. Do not use them: they do not reduce the held-out gap."
        commands = "flexros gap BAG --model patch.yaml      # a new log against the repaired model\n"
        commands += "flexros run SCENARIO --model patch.yaml  # simulate, with a feedforward that knows the effects\n"
        return (
            Paragraph(text),
            Listing(self._text, "patch.yaml, in the folder of this report."),
            Listing(commands, "Commands that use it."),
        )
