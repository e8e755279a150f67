"""Section: the verdict in a sentence, and the figures that matter most."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.gap.answer.order import largest_part
from flexros.gap.report.figure_words import (
    floors_words,
    gap_closed_words,
    gap_words,
    p_value_words,
    share_words,
    shows,
)
from flexros.gap.report.verdict import partial_sentence, reported_causes, verdict_lead
from flexros.gap.report.words import budget_words, capital, named, where_words
from flexros.report.base import AbstractSection, Block, Paragraph, Tiles
from flexros.report.number_text import number
from flexros.robot.exchange.joint_names import joints_line

if TYPE_CHECKING:
    from flexros.gap.result import DiagnosisResult, SignalGap
    from flexros.gap.schema import Diagnosis

_MANY_WARNINGS = 3
"""Warnings shown here; further ones are listed in the section on provenance (chosen)."""


class SummarySection(AbstractSection["DiagnosisResult"]):
    """Verdict, tiles, warnings."""

    title: ClassVar[str] = ""

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return the verdict, the main figures, and which joint each motor is."""
        texts = result.diagnosis.warnings
        warnings = [Paragraph(text, "warning") for text in texts[:_MANY_WARNINGS]]
        more = len(texts) - _MANY_WARNINGS
        if more > 0:
            warnings.append(Paragraph(f"{more} more warning{'s' * (more > 1)} at the end.", "warning"))
        lead = verdict_lead(result.diagnosis)
        partial = partial_sentence(result.diagnosis)
        lacking = (Paragraph(partial, "warning"),) if partial else ()
        joints = joints_line(result.robot)
        named = (Paragraph(f"{joints}.", "note"),) if joints else ()
        return (Paragraph(lead, "lead"), *lacking, Tiles(tuple(_tiles(result))), *named, *warnings)


def _tiles(result: DiagnosisResult) -> list[tuple[str, str, str, str]]:
    diagnosis, gap = result.diagnosis, result.diagnosis.gap
    tiles = [_cause_tile(diagnosis)]
    unit = "" if gap.unit == "1" else gap.unit
    floor = floors_words(gap)
    if gap.closed_fraction is None or gap.after is None or not shows(gap):
        tiles.append(("Gap", gap_words(gap.before), unit, floor))
    else:
        sizes = f"{gap_words(gap.before)} before, {gap_words(gap.after)} after, {floor}"
        tiles.append(("Gap closed, held-out data", gap_closed_words(gap).removesuffix(" %"), "%", sizes))
    closed_loop = next((signal for signal in result.signals if "closed loop" in signal.signal), None)
    if closed_loop is not None:
        tiles.append(_closed_loop_tile(closed_loop))
    return tiles + _where_tiles(result)


def _where_tiles(result: DiagnosisResult) -> list[tuple[str, str, str, str]]:
    """Return the joint with the largest part of the gap, and the first location of the map, in its own measure."""
    diagnosis, tiles = result.diagnosis, []
    if len(diagnosis.waterfall) > 1:
        joint = max(diagnosis.waterfall, key=lambda one: one.before)
        tiles.append(("Largest part of the gap", joint.joint, "", f"{share_words(joint.before)} of the held-out gap"))
    if diagnosis.where:
        first = diagnosis.where[0]
        detail = where_words(first, result.record.sample_time).removeprefix(first.joint).lstrip(",: ")
        p_value = p_value_words(first.p_value, result.simulated_logs).replace(" ", "\u00a0")
        tiles.append(("Clearest sign, before any hypothesis", first.joint, "", f"{capital(detail)}, {p_value}"))
    return tiles


def _cause_tile(diagnosis: Diagnosis) -> tuple[str, str, str, str]:
    """Return what closes most of several, numbers that the model lacks too, the probability of one, or the verdict."""
    causes = reported_causes(diagnosis)
    if diagnosis.verdict == "no_gap" or not causes:
        return "Verdict", diagnosis.verdict.replace("_", " "), "", "within noise and tolerance"
    if diagnosis.verdict == "unknown_effect":
        return "Verdict", "unknown effect", "", f"best known effect: {named(causes[0])}"
    more = f" and {len(causes) - 1} more" if len(causes) > 1 else ""
    largest, closed = largest_part(diagnosis.budget, diagnosis.causes)
    if more and largest is not None:
        effects = [share for share in diagnosis.budget if share.effect is not None]
        below = f"By {budget_words(largest)}, added first or removed last; {len(effects) - 1} more in the patch"
        return "Closed by the largest part, at least", share_words(closed).removesuffix(" %"), "%", below
    below = f"{capital(named(causes[0]))}{more}"
    return "Probability of the first cause", share_words(causes[0].probability).removesuffix(" %"), "%", below


def _closed_loop_tile(signal: SignalGap) -> tuple[str, str, str, str]:
    after = "" if signal.after is None else f"{number(signal.after, 2)} {signal.unit} after repair"
    return capital(signal.signal), number(signal.before, 2), signal.unit, after
