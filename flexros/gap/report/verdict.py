"""What a diagnosis found, in a sentence or two."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.report.words import (
    cause_words,
    closed_words,
    first_few,
    interval_words,
    listed,
    named,
    p_value_words,
    share_words,
    shows,
    where_words,
)
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.schema import Cause, Diagnosis, EffectLocation, GapNumbers

_PART = 0.5
"""A cause of at least this probability is told as part of the truth (chosen)."""
_SURE = 0.995
"""Probability above which none is given in the sentence (chosen)."""


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """Say in a sentence or two what was found, with numbers.

    Args:
        diagnosis: The answer.
    """
    words = {
        "no_gap": _no_gap,
        "explained": _explained,
        "ambiguous": _ambiguous,
        "unknown_effect": _unknown,
    }
    return words[diagnosis.verdict](diagnosis)


def told_causes(diagnosis: Diagnosis) -> tuple[Cause, ...]:
    """List the causes that a verdict names as part of the truth: all that are more probable than not, or the first.

    Args:
        diagnosis: The answer.
    """
    likely = tuple(cause for cause in diagnosis.causes if cause.probability >= _PART)
    return likely or diagnosis.causes[:1]


def _no_gap(diagnosis: Diagnosis) -> str:
    gap = diagnosis.gap
    text = (
        "No gap: model and log agree as well as noise and the tolerance of the model allow "
        f"({_size(gap, gap.before)} against a floor of {number(gap.noise_floor, 3)})"
    )
    if not diagnosis.where:
        return f"{text}."
    first = min(diagnosis.where, key=lambda place: place.p_value)
    place = where_words(first).partition(":")[0]
    return f"{text}; the most suspicious place, {place}, has {p_value_words(first.p_value)}."


def _explained(diagnosis: Diagnosis) -> str:
    causes = told_causes(diagnosis)
    if not causes:
        return f"There is a gap. {_where(diagnosis)}"
    sure = min(cause.probability for cause in causes)
    each, more = ("", "") if len(causes) == 1 else ("each ", " or more")
    how = "" if sure >= _SURE else f", {each}with a probability of {share_words(sure)}{more}"
    told = listed([cause_words(cause) for cause in causes])
    return f"The gap comes from {told}{how}. {_closed(diagnosis.gap)}".strip()


def _ambiguous(diagnosis: Diagnosis) -> str:
    probability = {(cause.effect, cause.location): cause.probability for cause in diagnosis.causes}
    rivals = sorted(_rivals(diagnosis), key=lambda place: -probability.get((place.effect, place.location), 0.0))
    told = [f"{named(place)} ({share_words(probability.get((place.effect, place.location), 0.0))})" for place in rivals]
    sure = [cause for cause in diagnosis.causes if cause.probability >= _SURE and not _in(cause, rivals)]
    beside = f"; beside it there is {listed([cause_words(cause) for cause in sure])}" if sure else ""
    return (
        f"There is a gap, and this log cannot tell {first_few(told, 'from')} apart{beside}. "
        f"{_closed(diagnosis.gap)} {_next(diagnosis)}"
    ).strip()


def _unknown(diagnosis: Diagnosis) -> str:
    text = "There is a gap that no known effect explains"
    if diagnosis.causes and diagnosis.gap.closed_fraction is not None:
        left = max(1 - diagnosis.gap.closed_fraction, 0.0)
        text += f": the best, {cause_words(diagnosis.causes[0])}, leaves {share_words(left)} of it on held-out data"
    return f"{text}. {_where(diagnosis)}".strip()


def _rivals(diagnosis: Diagnosis) -> tuple[EffectLocation, ...]:
    """Return the first group of effects that the log cannot tell apart, else the first two causes."""
    return diagnosis.ambiguity_groups[0] if diagnosis.ambiguity_groups else diagnosis.causes[:2]


def _in(cause: Cause, places: Sequence[EffectLocation]) -> bool:
    return any((cause.effect, cause.location) == (place.effect, place.location) for place in places)


def _closed(gap: GapNumbers) -> str:
    if gap.after is None:
        return ""
    sizes = (
        f"{_size(gap, gap.before)} before, {number(gap.after, 3)} after, {number(gap.noise_floor, 3)} without any gap"
    )
    if gap.closed_fraction is None or not shows(gap):
        return f"It is too small to show in predictions of held-out data: {sizes}."
    if gap.closed_fraction <= 0:
        return f"On held-out data the repaired model does not close the gap: {sizes}."
    within = interval_words(gap.interval)
    return (
        f"On held-out data the repaired model closes {closed_words(gap.closed_fraction)} of the gap{within}: {sizes}."
    )


def _size(gap: GapNumbers, value: float) -> str:
    return f"{number(value, 3)}{'' if gap.unit in ('', '1') else ' ' + gap.unit}"


def _where(diagnosis: Diagnosis) -> str:
    if not diagnosis.where:
        return ""
    first = diagnosis.where[0]
    return f"It shows most in {where_words(first)} ({p_value_words(first.p_value)})."


def _next(diagnosis: Diagnosis) -> str:
    return "" if diagnosis.next_experiment is None else f"To tell them, run {diagnosis.next_experiment.name} next."
