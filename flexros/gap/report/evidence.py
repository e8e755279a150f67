"""Section: what speaks for and against each of the first effects, with pictures of what they leave in the log."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar

from flexros.gap.report.ranking import NOTHING
from flexros.gap.report.signature_pictures import signature_pictures
from flexros.gap.report.words import capital, cause_words, first_few, listed, named, parameter_words, share_words
from flexros.report.base import AbstractSection, Block, Heading, Paragraph
from flexros.report.number_text import number

if TYPE_CHECKING:
    from flexros.gap.result import DiagnosisResult, RankedCandidate
    from flexros.gap.schema import EffectLocation

_SHOWN = 3
"""Effects whose evidence is shown."""
_LEAVES_LITTLE = 0.02
"""Share of the excess that counts as nearly nothing [1]."""
_CLEAR = 3.0
"""Standard deviations from zero that make a number certain (chosen)."""
_DECISIVE = 10.0
"""Difference of twice the log-likelihood that is decisive (Kass and Raftery 1995: "very strong")."""


class EvidenceSection(AbstractSection["DiagnosisResult"]):
    """For the first three effects: numbers, for, against, and the pictures of their signature."""

    title: ClassVar[str] = "The evidence"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return the evidence of each of the first effects."""
        if result.diagnosis.verdict == "no_gap":
            return ()
        blocks: list[Block] = []
        drawn: set[str] = set()
        for place, one in enumerate(result.ranking[:_SHOWN], start=1):
            heading = f"{place}. {capital(cause_words(one))}: {share_words(one.probability)}"
            blocks.append(Heading(heading))
            blocks += [Paragraph(text, "for") for text in speaks_for(one, result)]
            blocks += [Paragraph(text, "against") for text in speaks_against(one, result)]
            for picture in signature_pictures(one, result):
                if picture.caption not in drawn:  # effects at one joint share pictures
                    drawn.add(picture.caption)
                    blocks.append(picture)
        return tuple(blocks)


def speaks_for(one: RankedCandidate, result: DiagnosisResult) -> tuple[str, ...]:
    """List what speaks for an effect, a sentence each.

    Args:
        one: The effect.
        result: What was found.
    """
    told = []
    if one.score > 0:
        gain, cost = number(one.gain, 4), number(one.penalty, 3)
        if one.together_with:
            both = listed([named(place) for place in one.together_with])
            told.append(
                f"Together with {both} it raises twice the log-likelihood by {gain}, the parameters cost {cost}."
            )
        else:
            told.append(f"It raises twice the log-likelihood by {gain}, its parameters cost {cost}.")
    if one.holdout_gain is not None and one.holdout_gain > 0:
        told.append(f"It also predicts the data that it has not seen better: gain {number(one.holdout_gain, 4)} there.")
    if one.remainder is not None and one.remainder < _LEAVES_LITTLE:
        told.append(f"It leaves {share_words(max(one.remainder, 0.0))} of the excess over the noise floor.")
    clear = [name for name, value in one.parameters.items() if abs(value.value) > _CLEAR * value.std > 0]
    if clear:
        told.append(f"Clearly different from zero: {listed([_number(name, one) for name in clear])}.")
    return tuple(told)


def speaks_against(one: RankedCandidate, result: DiagnosisResult) -> tuple[str, ...]:
    """List what speaks against an effect, a sentence each.

    Args:
        one: The effect.
        result: What was found.
    """
    told = []
    first = result.ranking[0]
    if one.score <= 0:
        told.append(f"Its gain of {number(one.gain, 3)} does not pay for its parameters ({number(one.penalty, 3)}).")
    behind = first.score - one.score
    if behind > _DECISIVE:
        best = listed([named(first), *(named(place) for place in first.together_with)])
        told.append(f"{capital(best)} gain{'s' * (not first.together_with)} {number(behind, 4)} more.")
    if one.holdout_gain is not None and one.holdout_gain <= 0:
        told.append("It does not predict the data that it has not seen any better than the nominal model does.")
    if one.remainder is not None and one.remainder > result.settings.ranking.unexplained:
        told.append(f"It leaves {share_words(one.remainder)} of the excess over the noise floor unexplained.")
    unknown = [name for name, value in one.parameters.items() if not math.isfinite(value.std)]
    if unknown:
        told.append(f"Not determined by this log: {listed([name.replace('_', ' ') for name in unknown])}.")
    size = next(iter(one.parameters.items()), None)
    if size is not None and size[1].std > 0.5 * abs(size[1].value):
        told.append(f"Its size is hardly different from zero: {_number(size[0], one)}.")
    groups = [group for group in result.diagnosis.ambiguity_groups if any(_same(one, place) for place in group)]
    rivals = dict.fromkeys(named(place) for group in groups for place in group if not _same(one, place))
    if rivals:
        told.append(f"This log cannot tell it from {first_few(list(rivals), 'or')}.")
    if one.probability < result.null_probability:
        told.append(f"That there is {NOTHING} is more probable ({share_words(result.null_probability)}).")
    return tuple(told)


def _number(name: str, one: RankedCandidate) -> str:
    return f"{name.replace('_', ' ')} {parameter_words(name, one.parameters[name])}"


def _same(one: RankedCandidate, place: EffectLocation) -> bool:
    return (one.effect, one.location) == (place.effect, place.location)
