"""Section: frequency responses of an identification experiment, with uncertainty and levels of distortion."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.analysis.frequency_responses import relative_deviation
from flexros.identify.frf.response_picture import position_name, response_picture
from flexros.identify.report.distortion_levels import distortion_blocks
from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.number_text import number, percent

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.frequency_responses import LogResponses
    from flexros.analysis.run_analysis import Analysis
    from flexros.identify.frf.frequency_response import FrequencyResponse


class FrequencyResponseSection(AbstractSection["Sequence[Analysis]"]):
    """Per run of an identification: measured responses by position, table, distortions and warnings."""

    title: ClassVar[str] = "Frequency responses"

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return the blocks of all runs; none where no run is an identification."""
        blocks: list[Block] = []
        for analysis in analyses:
            if analysis.responses is not None:
                heading = f"{analysis.label}: " if len(analyses) > 1 else ""
                blocks.extend(response_blocks(analysis.responses, heading))
        return tuple(blocks)


def response_blocks(responses: LogResponses, heading: str = "") -> tuple[Block, ...]:
    """Return picture, table of deviations, levels of distortion and warnings of the responses of a run.

    Args:
        responses: The responses.
        heading: Begin of the first sentence, which names the run.
    """
    if not responses.positions:
        return (Paragraph(f"{heading}The frequency responses were not estimated: {responses.reason}"),)
    caption = (
        "Measured response of the motor accelerations to the motor torques, columns: input, rows: output; shaded: one "
        "standard deviation, where it is known. The menus choose position, and magnitude or phase."
    )
    return (
        Paragraph(f"{heading}{_sentence(responses.positions)}"),
        Picture(response_picture(responses.positions), caption),
        _table(responses.positions),
        *distortion_blocks(responses.positions),
        *(Paragraph(f"Warning: {text}.", "note") for text in responses.warnings),
    )


def _sentence(positions: Sequence[FrequencyResponse]) -> str:
    first = positions[0]
    where = "one position" if len(positions) == 1 else f"{len(positions)} positions"
    return (
        f"Best linear approximation from torque commands to motor accelerations in {where}, "
        f"{len(first.frequency)} lines from {number(first.frequency[0], 3)} to {number(first.frequency[-1], 3)} Hz."
    )


def _table(positions: Sequence[FrequencyResponse]) -> TextTable:
    rows = []
    for index, response in enumerate(positions):
        shares = relative_deviation(response).values()
        counts = (str(len(response.frequency)), str(response.n_blocks), str(response.n_periods))
        texts = ("-" if share is None else percent(share) for share in shares)
        rows.append((position_name(index, response.gears), *counts, *texts))
    header = ("Position", "lines", "blocks", "periods", *(f"{name} [%]" for name in positions[0].output_names))
    caption = "Standard deviation of the diagonal responses, motor to itself, relative to their magnitude (median)."
    return TextTable(header, tuple(rows), caption)
