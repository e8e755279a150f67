"""Section: the verdict in a sentence, and the figures that matter most."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.gap.answer.order import PLACES, closed_by
from flexros.gap.report.verdict import partial_sentence, reported_causes, verdict_sentence
from flexros.gap.report.words import (
    capital,
    closed_words,
    floors_words,
    gap_words,
    named,
    p_value_words,
    share_words,
    shows,
    where_words,
)
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
        lead = verdict_sentence(result.diagnosis).replace(" %", "\u00a0%")
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
        tiles.append(("Gap closed, held-out data", closed_words(gap.closed_fraction).removesuffix(" %"), "%", sizes))
    closed_loop = next((signal for signal in result.signals if "closed loop" in signal.signal), None)
    if closed_loop is not None:
        tiles.append(_closed_loop_tile(closed_loop))
    if diagnosis.where:
        first = diagnosis.where[0]
        detail = where_words(first, result.record.sample_time).partition(", ")[2]
        below = f"{capital(detail)}, {p_value_words(first.p_value)}" if detail else p_value_words(first.p_value)
        tiles.append(("Where it shows most", first.joint, "", below.replace("p = ", "p\u00a0=\u00a0")))
    return tiles


def _cause_tile(diagnosis: Diagnosis) -> tuple[str, str, str, str]:
    """Return what closes most of several, numbers that the model lacks too, the probability of one, or the verdict."""
    causes = reported_causes(diagnosis)
    if diagnosis.verdict == "no_gap" or not causes:
        return "Verdict", diagnosis.verdict.replace("_", " "), "", "within noise and tolerance"
    if diagnosis.verdict == "unknown_effect":
        return "Verdict", "unknown effect", "", f"best known effect: {named(causes[0])}"
    more = f" and {len(causes) - 1} more" if len(causes) > 1 else ""
    below, steps = f"{capital(named(causes[0]))}{more}", [step for one in diagnosis.waterfall for step in one.steps]
    largest = max(steps, key=lambda step: closed_by(step, diagnosis.waterfall), default=None)
    closed = 0.0 if largest is None else closed_by(largest, diagnosis.waterfall)
    if more and largest is not None and 0 < round(closed, PLACES) <= 1:  # else others open what it closes
        others = len({(step.effect, step.location) for step in steps}) - 1
        below = f"{capital(named(largest))} and {others} more in the patch"
        return "Closed by the largest part", share_words(min(closed, 1.0)).removesuffix(" %"), "%", below
    return "Probability of the first cause", share_words(causes[0].probability).removesuffix(" %"), "%", below


def _closed_loop_tile(signal: SignalGap) -> tuple[str, str, str, str]:
    after = "" if signal.after is None else f"{number(signal.after, 2)} {signal.unit} after repair"
    return capital(signal.signal), number(signal.before, 2), signal.unit, after
