"""Section: evidence for and against each of the first effects, with pictures of their signatures."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

from flexros.gap.report.figure_words import share_words
from flexros.gap.report.ranking import explanation_of, first_of_ranking
from flexros.gap.report.signature_pictures import signature_pictures
from flexros.gap.report.words import capital, cause_words, first_few, listed, named, parameter_words, partners_words
from flexros.gap.schema import same_effect
from flexros.report.base import AbstractSection, Block, Folded, Heading, Paragraph
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.result import DiagnosisResult, RankedCandidate

_SHOWN = 3
"""Effects whose evidence is shown; that of further causes is folded (chosen)."""
_NOT_FOLDED = 0.05
"""Probability below which the evidence of an effect that is not the first is folded [1] (chosen)."""
_LEAVES_LITTLE = 0.02
"""Share of the excess that counts as nearly nothing [1] (chosen)."""
_CLEAR = 3.0
"""Standard deviations from zero from which a parameter is clearly different from zero (chosen)."""
_DECISIVE = 10.0
"""Difference of twice the log-likelihood that is decisive (Kass and Raftery 1995: "very strong")."""


class EvidenceSection(AbstractSection["DiagnosisResult"]):
    """For the first three effects and all further causes: evidence for and against, pictures of their signatures."""

    title: ClassVar[str] = "The evidence"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return the evidence of each of the first effects."""
        if result.diagnosis.verdict == "no_gap":
            return ()
        blocks: list[Block] = []
        drawn: set[str] = set()
        told: set[frozenset[tuple[str, str]]] = set()
        for rank, candidate in enumerate(first_of_ranking(result, _SHOWN), start=1):
            explanation = explanation_of(candidate)
            found: list[Block] = []
            if rank == 1 and len(explanation) > 1:
                blocks.append(Heading(f"The explanation by {len(explanation)} effects"))
                blocks += _common(candidate, result, whole=True)
            elif explanation not in told:
                found += _common(candidate, result)
            told.add(explanation)
            heading = f"{rank}. {capital(cause_words(candidate))}: {share_words(candidate.probability)}"
            found += _paragraphs(evidence_for(candidate, result), evidence_against(candidate, result))
            for picture in signature_pictures(candidate, result):
                if picture.caption not in drawn:  # effects at one joint share pictures
                    drawn.add(picture.caption)
                    found.append(picture)
            folded = rank > _SHOWN or (rank > 1 and candidate.probability < _NOT_FOLDED)
            blocks += [Folded(heading, tuple(found))] if folded else [Heading(heading), *found]
        return tuple(blocks)


def _common(candidate: RankedCandidate, result: DiagnosisResult, *, whole: bool = False) -> list[Block]:
    """Return the evidence for and against an explanation, in words of one of its effects or of the whole of it."""
    subject = replace(candidate, together_with=()) if whole else candidate
    return _paragraphs(explanation_for(subject), explanation_against(subject, result))


def _paragraphs(of_it: Sequence[str], against: Sequence[str]) -> list[Block]:
    return [*(Paragraph(text, "for") for text in of_it), *(Paragraph(text, "against") for text in against)]


def explanation_for(candidate: RankedCandidate) -> tuple[str, ...]:
    """List the evidence for an effect together with those that it explains the log with, one sentence each."""
    texts = []
    if candidate.score > 0:
        gain, cost = number(candidate.gain, 4), number(candidate.penalty, 3)
        if candidate.together_with:
            texts.append(
                f"Together with {partners_words(candidate)} it raises twice the log-likelihood by {gain}, the "
                f"parameters cost {cost}."
            )
        else:
            texts.append(f"It raises twice the log-likelihood by {gain}, its parameters cost {cost}.")
    if candidate.holdout_gain is not None and candidate.holdout_gain > 0:
        texts.append(f"It also predicts held-out data better: gain {number(candidate.holdout_gain, 4)} there.")
    if candidate.remainder is not None and candidate.remainder < _LEAVES_LITTLE:
        texts.append(f"It leaves {share_words(max(candidate.remainder, 0.0))} of the excess over the noise floor.")
    return tuple(texts)


def explanation_against(candidate: RankedCandidate, result: DiagnosisResult) -> tuple[str, ...]:
    """List the evidence against an effect together with those that it explains the log with, one sentence each.

    Args:
        candidate: The effect.
        result: The diagnosis.
    """
    texts = []
    first = result.ranking[0]
    if candidate.score <= 0:
        texts.append(
            f"Its gain of {number(candidate.gain, 3)} does not justify its parameters ({number(candidate.penalty, 3)})."
        )
    behind = first.score - candidate.score
    if behind > _DECISIVE:
        best = named(first) + (f", together with {partners_words(first)}," if first.together_with else "")
        texts.append(f"{capital(best)} gains {number(behind, 4)} more.")
    if candidate.holdout_gain is not None and candidate.holdout_gain <= 0:
        texts.append("It does not predict held-out data better than the nominal model.")
    if candidate.remainder is not None and candidate.remainder > result.settings.ranking.unexplained:
        texts.append(f"It leaves {share_words(candidate.remainder)} of the excess over the noise floor unexplained.")
    return tuple(texts)


def evidence_for(candidate: RankedCandidate, result: DiagnosisResult) -> tuple[str, ...]:
    """List the evidence for an effect itself, one sentence each.

    Args:
        candidate: The effect.
        result: The diagnosis.
    """
    texts = []
    opened = next((one.share_last for one in result.diagnosis.budget if same_effect(one, candidate)), None)
    if opened is not None and opened > 0:
        gap = "all of the held-out gap and more" if opened > 1 else f"{share_words(opened)} of the held-out gap"
        texts.append(f"Without it, and with all others, {gap} opens.")
    clear = [name for name, value in candidate.parameters.items() if abs(value.value) > _CLEAR * value.std > 0]
    if clear:
        texts.append(f"Clearly different from zero: {listed([_number(name, candidate) for name in clear])}.")
    return tuple(texts)


def evidence_against(candidate: RankedCandidate, result: DiagnosisResult) -> tuple[str, ...]:
    """List the evidence against an effect itself, one sentence each.

    Args:
        candidate: The effect.
        result: The diagnosis.
    """
    texts = []
    unknown = [name for name, value in candidate.parameters.items() if not math.isfinite(value.std)]
    if unknown:
        texts.append(f"Not identifiable from this log: {listed([name.replace('_', ' ') for name in unknown])}.")
    size = next(iter(candidate.parameters.items()), None)
    if size is not None and size[1].std > 0.5 * abs(size[1].value):
        texts.append(f"Its size is hardly different from zero: {_number(size[0], candidate)}.")
    groups = [
        group
        for group in result.diagnosis.ambiguity_groups
        if any(same_effect(candidate, location) for location in group)
    ]
    rivals = dict.fromkeys(
        named(location) for group in groups for location in group if not same_effect(candidate, location)
    )
    if rivals:
        texts.append(f"This log cannot distinguish it from {first_few(list(rivals), 'or')}.")
    if candidate.probability < result.null_probability:
        texts.append(f"No effect at all is more probable ({share_words(result.null_probability)}).")
    return tuple(texts)


def _number(name: str, candidate: RankedCandidate) -> str:
    return f"{name.replace('_', ' ')} {parameter_words(name, candidate.parameters[name])}"
