"""The verdict of a diagnosis in a sentence or two."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects.left_out import RotorInertia, ToolLoad
from flexros.gap.answer.order import shares_of
from flexros.gap.held_out.closed_share import NOTHING
from flexros.gap.report.figure_words import (
    gap_closed_words,
    gap_words,
    interval_words,
    p_value_words,
    share_words,
    shows,
    with_std,
)
from flexros.gap.report.words import (
    LIKELY,
    capital,
    cause_words,
    causes_words,
    effect_words,
    first_few,
    listed,
    location_words,
    named,
    where_words,
)
from flexros.gap.schema import ANSWERED, NEXT_EXPERIMENT, same_effect
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from flexros.gap.schema import (
        Cause,
        Diagnosis,
        EffectLocation,
        Excess,
        GapNumbers,
        ModelNumber,
        ToleranceSensitivity,
    )

_LACKED = (RotorInertia.name, ToolLoad.name)
"""Numbers that a robot file may leave out."""
_FEW_LACKED = 3
"""Numbers that the model lacks, stated one by one up to this many; of more the rotors are gathered (chosen)."""
_SURE = 0.995
"""Probability from which it is not stated in the sentence (chosen)."""
_NEARLY_SURE = 0.99
"""Probability above which it is written as "over 99 %"."""
_TIE = 0.2
"""Change of a probability below which rivals are about as probable with any tolerances [1] (chosen)."""


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """Return the verdict in a sentence or two, with figures."""
    words = {
        "no_gap": _no_gap,
        "explained": _explained,
        "partly_explained": _partly,
        "ambiguous": _ambiguous,
        "unknown_effect": _unknown,
    }
    return words[diagnosis.verdict](diagnosis)


def partial_sentence(diagnosis: Diagnosis) -> str:
    """Say what a diagnosis lacks that was ended before its search was complete; empty where it was complete."""
    partial = diagnosis.partial
    if partial is None:
        return ""
    what = "its time limit ended the search" if partial.reason == "time_limit" else "the diagnosis was interrupted"
    step = f"in step '{partial.step}'" if partial.step else "before its first step"
    text = f"Partial result: {what} after {number(partial.after, 3)} s, {step}"
    left_out = f" There was no time for: {', '.join(partial.left_out)}." if partial.left_out else ""
    if partial.step in (ANSWERED, NEXT_EXPERIMENT):
        return f"{text}; the search for causes was complete.{left_out}"
    text += ". Effects may be missing or replace others, and the probabilities compare only what was tried."
    return f"{text}{left_out}"


def reported_causes(diagnosis: Diagnosis) -> tuple[Cause, ...]:
    """List the causes that a verdict names, in their order.

    They are the effects that the budget is divided among, of which the closed share is; without a budget all that are
    more probable than not, otherwise the most probable one. Those of which the log determines no size are left out
    where there are others that close any of the gap.
    """
    divided = {(share.effect, share.location) for share in diagnosis.budget}
    divided |= {(step.effect, step.location) for waterfall in diagnosis.waterfall for step in waterfall.steps}
    repaired = tuple(cause for cause in diagnosis.causes if (cause.effect, cause.location) in divided)
    likely = repaired or tuple(cause for cause in diagnosis.causes if cause.probability >= LIKELY)
    sized = tuple(cause for cause in likely if cause.determined)
    shares = [max(shares_of(cause, diagnosis.budget, diagnosis.waterfall)) for cause in sized]
    closing = not diagnosis.budget or any(share >= NOTHING for share in shares)
    return (sized if sized and closing else likely) or diagnosis.causes[:1]


def tolerance_sentence(diagnosis: Diagnosis) -> str:
    """Say which names change with halved or doubled tolerances of the model; empty where none does."""
    changing = hanging_names(diagnosis)
    if not changing:
        return ""
    texts = []
    for row in changing:
        sizes = {"halved": row.halved, "stated": row.stated, "doubled": row.doubled}
        texts.append(f"{named(row)} (with {listed([name for name, p in sizes.items() if p >= LIKELY])} ones)")
    return (
        f"Which effects are named hangs on the tolerances of the model, which were stated and not measured: "
        f"{first_few(texts, most=4)}."
    )


def hanging_names(diagnosis: Diagnosis) -> list[ToleranceSensitivity]:
    """List the names that change with halved or doubled tolerances, without rivals that are a tie with any of them."""
    rivals = [one for group in diagnosis.ambiguity_groups for one in group]
    return [
        row
        for row in diagnosis.tolerance_sensitivity
        if row.changes
        and not (
            any(same_effect(row, rival) for rival in rivals)
            and max(row.halved, row.stated, row.doubled) - min(row.halved, row.stated, row.doubled) < _TIE
        )
    ]


def verdict_lead(diagnosis: Diagnosis) -> str:
    """Return the verdict for a report: its word, and its sentence."""
    word, sentence = capital(diagnosis.verdict.replace("_", " ")), verdict_sentence(diagnosis)
    return sentence if sentence.startswith(word) else f"{word}: {sentence}"


def _no_gap(diagnosis: Diagnosis) -> str:
    gap = diagnosis.gap
    text = (
        "No gap: model and log agree as well as noise and the tolerance of the model allow "
        f"({_size(gap, gap.before)} against a floor of {number(gap.noise_floor, 3)})"
    )
    if diagnosis.where:
        first = min(diagnosis.where, key=lambda location: location.p_value)
        location = where_words(first).partition(":")[0]
        text += f"; the most suspicious location, {location}, has {_p_words(diagnosis, first)}"
    lacking = _lacking(diagnosis).removesuffix(".")
    return f"{text}. {lacking}: it is the model with the patch that agrees." if lacking else f"{text}."


def _explained(diagnosis: Diagnosis) -> str:
    causes = reported_causes(diagnosis)
    if not causes:
        return f"There is a gap. {_where(diagnosis)}"
    sure = min(cause.probability for cause in causes)
    each = "" if len(causes) == 1 else "each "
    least = "" if len(causes) == 1 or sure > _NEARLY_SURE else "at least "  # which is said as "over 99 %"
    how = "" if sure >= _SURE else f", {each}with a probability of {least}{share_words(sure)}"
    names = causes_words(causes)
    return " ".join(f"The gap comes from {names}{how}. {_lacking(diagnosis)} {_closed(diagnosis.gap)}".split())


def _partly(diagnosis: Diagnosis) -> str:
    names = causes_words(reported_causes(diagnosis))
    text = " ".join(f"A part of the gap comes from {names}. {_lacking(diagnosis)} {_closed(diagnosis.gap)}".split())
    rest = next((one for one in diagnosis.unexplained if one.regime == "all"), None)
    if rest is not None:
        text += f" Most of what is left is in {rest.joint} ({share_words(rest.share)} of the gap)."
    return f"{text} {tolerance_sentence(diagnosis)}".strip()


def _lacking(diagnosis: Diagnosis) -> str:
    """Say which numbers the model lacks that the log determines and no cause is; empty where they have no share."""
    found = {key: size for key, size in _lacked(diagnosis).items() if size is None or size.determined}
    rotors = {location: size for (effect, location), size in found.items() if effect == RotorInertia.name}
    gathered = len(found) > _FEW_LACKED and len(rotors) > 1
    texts = [_lacked_words(*key, size) for key, size in found.items() if not gathered or key[0] != RotorInertia.name]
    if gathered:
        texts.append(f"rotor inertia ({listed([*rotors])}){_range_words(rotors.values())}")
    return f"The model lacked {listed(texts)}." if texts else ""


def _range_words(sizes: Iterable[ModelNumber | None]) -> str:
    """Write least and largest of sizes of one unit, e.g. ", 0.15 to 0.60 kg m2"; empty where one is not known."""
    known = [(size.value, size.unit) if size else (0.0, "") for size in sizes]
    units = {unit for _, unit in known}
    if len(units) > 1 or "" in units:
        return ""
    return f", {number(min(known)[0], 2)} to {number(max(known)[0], 2)} {units.pop()}"


def _lacked(diagnosis: Diagnosis) -> dict[tuple[str, str], ModelNumber | None]:
    """Return the sizes of what the model lacks and no cause is, by effect and location; without a gap of all."""
    sizes = {
        (ToolLoad.name, one.location) if one.name == f"{ToolLoad.name}.mass" else (RotorInertia.name, one.location): one
        for one in diagnosis.model_numbers
        if one.nominal == 0 and one.name in (f"{ToolLoad.name}.mass", f"{one.location}.inertia")
    }
    if diagnosis.verdict == "no_gap":
        return dict(sizes)
    named = {one.effect for one in diagnosis.causes}  # a load of servos is a cause, and named as one
    rows = [(one.effect, one.location) for one in diagnosis.budget if one.effect in _LACKED and one.effect not in named]
    return {(effect, location): sizes.get((effect, location)) for effect, location in rows if effect is not None}


def _lacked_words(effect: str, location: str, size: ModelNumber | None) -> str:
    """Write a number that the model lacks, with its size where that is known."""
    words = f"{effect_words(effect)} {location_words(location)}"
    return words if size is None else f"{words}, {with_std(size.value, size.std, size.unit)}"


def _ambiguous(diagnosis: Diagnosis) -> str:
    guessed = tolerance_sentence(diagnosis)
    if guessed and not diagnosis.ambiguity_groups:
        return f"There is a gap. {guessed} {_closed(diagnosis.gap)}".strip()
    probability = {(cause.effect, cause.location): cause.probability for cause in diagnosis.causes}
    chances = [(probability.get((one.effect, one.location), 0.0), one) for one in _rivals(diagnosis)]
    chances.sort(key=lambda pair: -pair[0])
    rivals = [one for _, one in chances]
    names = [f"{named(one)} ({_chance(diagnosis, one, chance)})" for chance, one in chances]
    sure = [cause for cause in diagnosis.causes if cause.probability >= _SURE and not _in(cause, rivals)]
    addition = f"; in addition there {'are' if len(sure) > 1 else 'is'} {causes_words(sure)}" if sure else ""
    alone = len(names) == 1
    doubt = f"does not show whether there is {names[0]}" if alone else f"cannot distinguish {first_few(names, 'from')}"
    text = f"There is a gap, and this log {doubt}{addition}. {_closed(diagnosis.gap)} {guessed} {_next(diagnosis)}"
    return " ".join(text.split())


def _chance(diagnosis: Diagnosis, rival: EffectLocation, probability: float) -> str:
    """Say how probable a rival is, or with which tolerances where it is not with those that are stated."""
    for row in diagnosis.tolerance_sensitivity if not probability else ():
        if same_effect(row, rival) and row.changes:
            return f"with {'halved' if row.halved > row.doubled else 'doubled'} tolerances"
    return share_words(probability)


def _unknown(diagnosis: Diagnosis) -> str:
    tried = "no known effect" if diagnosis.partial is None else "none of the effects tried so far"
    text = f"There is a gap that {tried} explains"
    if diagnosis.causes and diagnosis.gap.closed_fraction is not None:
        left = max(1 - diagnosis.gap.closed_fraction, 0.0)
        first = next((cause for cause in diagnosis.causes if cause.determined), diagnosis.causes[0])
        effects = {(one.effect, one.location) for one in diagnosis.budget if one.effect not in (None, *_LACKED)}
        others = len(effects) - 1
        beside = f" and {others} other effect{'s' if others > 1 else ''}" if others > 0 else ""
        best = "the best one" if others <= 0 else "the best explanation"
        text += f": {best}, {cause_words(first)}{beside}, leaves {share_words(left)} of it on held-out data"
    return f"{text}. {_where(diagnosis)}".strip()


def _rivals(diagnosis: Diagnosis) -> tuple[EffectLocation, ...]:
    """Return the first ambiguity group, otherwise the first two causes."""
    return diagnosis.ambiguity_groups[0] if diagnosis.ambiguity_groups else diagnosis.causes[:2]


def _in(cause: Cause, rivals: Sequence[EffectLocation]) -> bool:
    return any(same_effect(cause, rival) for rival in rivals)


def _closed(gap: GapNumbers) -> str:
    if gap.after is None:
        return ""
    sizes = (
        f"{_size(gap, gap.before)} before, {gap_words(gap.after)} after, {number(gap.noise_floor, 3)} without any gap"
    )
    if gap.tolerance_floor is not None:
        sizes += f", {gap_words(gap.tolerance_floor)} with torques off by their tolerance"
    if gap.closed_fraction is None or not shows(gap):
        return f"It is too small to show in predictions of held-out data: {sizes}."
    if gap.closed_fraction <= 0:
        return f"On held-out data the repaired model does not close the gap: {sizes}."
    within = interval_words(gap.interval)
    return f"On held-out data the repaired model closes {gap_closed_words(gap)} of the gap{within}: {sizes}."


def _size(gap: GapNumbers, value: float) -> str:
    return f"{gap_words(value)}{'' if gap.unit in ('', '1') else ' ' + gap.unit}"


def _where(diagnosis: Diagnosis) -> str:
    if not diagnosis.where:
        return ""
    first = diagnosis.where[0]
    return f"It is largest in {where_words(first)} ({_p_words(diagnosis, first)})."


def _p_words(diagnosis: Diagnosis, location: Excess) -> str:
    return p_value_words(location.p_value, (diagnosis.provenance.get("where") or {}).get("realisations", 0))


def _next(diagnosis: Diagnosis) -> str:
    return "" if diagnosis.next_experiment is None else f"To separate them, run {diagnosis.next_experiment.name} next."
