"""Section: the verdict in a few sentences, and the figures that matter most."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.identify.report.verdict import verdict
from flexros.identify.report.words import counted
from flexros.report.base import AbstractSection, Block, Paragraph, Tiles
from flexros.report.number_text import number, percent

if TYPE_CHECKING:
    from flexros.identify.result import IdentificationResult

_MANY_WARNINGS = 4
"""More warnings than this are listed in the section on provenance only (chosen)."""


class SummarySection(AbstractSection["IdentificationResult"]):
    """Verdict, tiles, warnings."""

    title: ClassVar[str] = ""

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return the verdict and the main figures."""
        warnings = [Paragraph(text, "warning") for text in result.warnings[:_MANY_WARNINGS]]
        more = len(result.warnings) - _MANY_WARNINGS
        if more > 0:
            warnings.append(Paragraph(f"{more} more warnings are listed at the end.", "warning"))
        return (Paragraph(verdict(result).replace(" %", "\u00a0%"), "lead"), Tiles(_tiles(result)), *warnings)


def _tiles(result: IdentificationResult) -> tuple[tuple[str, str, str, str], ...]:
    names, judged = result.fit.names, result.identifiability
    determined = len(judged.names("determined"))
    below = f"{len(judged.names('weak'))} weak, {len(judged.names('not_determined'))} not determined"
    deviations = [each.relative for each in judged.parameters if each.name.endswith(".stiffness")]
    which = "stiffness" if deviations else "parameter"
    deviations = deviations or [each.relative for each in judged.parameters]
    tiles = [
        ("Determined within 10 %", f"{determined}", f"of {len(names)}", below),
        (
            f"Uncertainty, median {which}",
            percent(float(np.median(deviations)), 2),
            "%",
            f"largest {percent(max(deviations), 2)} %, one standard deviation",
        ),
        (
            "Misfit over uncertainty",
            number(float(np.sqrt(result.covariance.reduced_cost)), 3) if _known(result) else "-",
            "rms",
            "1: the model explains all but noise",
        ),
    ]
    if result.facts is not None:
        positions = f"{counted(result.facts.positions, 'position')}, {counted(result.facts.experiments, 'experiment')}"
        tiles.append(("Robot time", number(result.facts.robot_time / 60, 3), "min", positions))
    return tuple(tiles)


def _known(result: IdentificationResult) -> bool:
    return result.covariance.basis != "residuals"
