"""Scores of crowds: which of many hidden effects are named, what else is, and what is said of sizes and shares."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.validation.blind.score.coverage import COMPARABLE, FittedSize
from flexros.validation.blind.score.nested import same, same_place
from flexros.validation.blind.score.statistics import Share, median, share
from flexros.validation.blind.score.true_model import library_effects

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flexros.gap.schema import BudgetShare, Cause, EffectLocation
    from flexros.validation.blind.deviation import Deviation
    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.blind.score.crowd_truth import TrueShare

CLAIMED = 0.5
"""Probability from which a cause is counted as named: more probable than not."""
OVER = 2.0
"""Gap of the third log over its floor from which more than the floor is left [1]."""
CLOSED = 0.97
"""Share that a patch must close of what the true effects close (the goal)."""
BINS: Mapping[str, tuple[float, float]] = {
    "50 to 200": (50.0, 200.0),
    "200 to 1e3": (200.0, 1e3),
    "1e3 to 1e4": (1e3, 1e4),
    "1e4 to 1e5": (1e4, 1e5),
    "1e5 and more": (1e5, float("inf")),
}
"""Bins of the gain of an effect added last [nats]."""


@dataclass(frozen=True)
class CrowdScore:
    """Figures of crowds; an effect of the truth counts where it is of the library.

    Attributes:
        cases: Number of crowds.
        recall: Hidden effects that are named at their place.
        recall_nested: The same, an effect that holds the true one as a special case counted.
        recall_grouped: Hidden effects that are named, or called ambiguous with what is named.
        precision: Named causes that are hidden at that place.
        precision_nested: The same, nested effects counted.
        precision_grouped: Named causes that are hidden there, or called ambiguous with one that is.
        whole: Crowds of which all effects are named, and nothing else.
        whole_nested: The same, nested effects counted.
        location: Named causes whose effect is hidden anywhere that are at the right place.
        covered: Sizes of rightly named effects in their 95 % intervals, nominal model exact.
        over_claims: Crowds called explained although more than the floor is left on the third log.
        over_truth: The same, and more than `OVER` times what the true effects leave there.
        incomplete: Crowds called explained although an effect, or a cause outside the library, is missing.
        third_97: Crowds of the library alone whose patch closes 97 % of what the true effects close on the third log.
        closed_third: Median closed fraction of the patches there.
        closed_truth: Median closed fraction of the true effects there.
        first_off: Median distance of the stated share, added first, from the true one [1].
        last_off: The same of the share removed last.
        refused: Crowds without a diagnosis.
        by_size: Recall, nested effects counted, by the gain of the effect.
        verdicts: Numbers of crowds by verdict.
        seconds: Median time of a diagnosis [s].
    """

    cases: int
    recall: Share
    recall_nested: Share
    recall_grouped: Share
    precision: Share
    precision_nested: Share
    precision_grouped: Share
    whole: Share
    whole_nested: Share
    location: Share
    covered: Share
    over_claims: Share
    over_truth: Share
    incomplete: Share
    third_97: Share
    closed_third: float
    closed_truth: float
    first_off: float
    last_off: float
    refused: Share
    by_size: dict[str, Share]
    verdicts: dict[str, int]
    seconds: float


def crowds_of(answers: Sequence[Answer]) -> list[Answer]:
    """List the crowds among cases."""
    return [one for one in answers if one.truth.kind == "crowd"]


def has_outside(one: Answer) -> bool:
    """Whether a cause outside the library is hidden."""
    return len(library_effects(one.truth)) < len(one.truth.deviations)


def claimed(one: Answer) -> list[Cause]:
    """List the causes that an answer names: those that are more probable than not."""
    return [cause for cause in one.causes if cause.probability >= CLAIMED]


def found(one: Answer, hidden: Deviation, nested: bool = False) -> bool:
    """Whether a hidden effect is named at its place.

    Args:
        one: The case.
        hidden: What is hidden.
        nested: Whether an effect that holds it as a special case counts.
    """
    return any(
        same(hidden.effect, cause.effect, nested) and same_place(one.truth.robot, hidden.location, cause.location)
        for cause in claimed(one)
    )


def found_or_equal(one: Answer, hidden: Deviation) -> bool:
    """Whether a hidden effect is named, or called ambiguous with what is named; arguments as for `found`."""
    here = any(_is(one, hidden, other) for cause in claimed(one) for other in _equals(one, cause))
    return here or found(one, hidden)


def _right_or_equal(one: Answer, cause: Cause) -> bool:
    """Whether a named cause is hidden at its place, or called ambiguous with one that is."""
    equal = any(_is(one, hidden, other) for other in _equals(one, cause) for hidden in one.truth.deviations)
    return equal or one.right(cause, placed=True)


def _equals(one: Answer, cause: Cause) -> list[EffectLocation]:
    """List the effects that an answer calls ambiguous with a cause, itself included."""
    groups = one.diagnosis.ambiguity_groups if one.diagnosis is not None else ()
    itself = (cause.effect, cause.location)
    return [other for group in groups if itself in {(a.effect, a.location) for a in group} for other in group]


def _is(one: Answer, hidden: Deviation, other: EffectLocation) -> bool:
    return hidden.effect == other.effect and same_place(one.truth.robot, hidden.location, other.location)


def complete(one: Answer, nested: bool = False) -> bool:
    """Whether all that is hidden is named; arguments as for `found`."""
    return all(found(one, hidden, nested) for hidden in one.truth.deviations)


def crowd_score(answers: Sequence[Answer]) -> CrowdScore:
    """Count.

    Args:
        answers: The cases; others than crowds are skipped.

    Returns:
        The figures.
    """
    crowds = crowds_of(answers)
    effects = [(one, hidden, gain) for one in crowds for hidden, gain in _effects(one)]
    named = [(one, cause) for one in crowds for cause in claimed(one)]
    tried = [one for one in crowds if not has_outside(one) and _closed_truth(one)]
    shares = [pair for one in crowds for pair in _shares(one)]
    explained = [one for one in crowds if one.diagnosis is not None and one.diagnosis.verdict == "explained"]
    return CrowdScore(
        cases=len(crowds),
        recall=share(found(one, hidden) for one, hidden, _ in effects),
        recall_nested=share(found(one, hidden, nested=True) for one, hidden, _ in effects),
        recall_grouped=share(found_or_equal(one, hidden) for one, hidden, _ in effects),
        precision=share(one.right(cause, placed=True) for one, cause in named),
        precision_nested=share(one.right(cause, nested=True, placed=True) for one, cause in named),
        precision_grouped=share(_right_or_equal(one, cause) for one, cause in named),
        whole=share(_whole(one) for one in crowds),
        whole_nested=share(_whole(one, nested=True) for one in crowds),
        location=share(one.right(cause, placed=True) for one, cause in named if one.right(cause)),
        covered=share(size.covered for size in crowd_sizes(crowds)),
        over_claims=share(one in explained and over_claimed(one) for one in crowds),
        over_truth=share(one in explained and over_claimed(one, _left_by_truth(one)) for one in crowds),
        incomplete=share(one in explained and not complete(one, nested=True) for one in crowds),
        third_97=share((one.closed_third or 0.0) >= CLOSED * (_closed_truth(one) or 1.0) for one in tried),
        closed_third=median([one.closed_third for one in crowds]),
        closed_truth=median([_closed_truth(one) for one in crowds]),
        first_off=median([_distance(said.share_first, true.share_first) for said, true in shares]),
        last_off=median([_distance(said.share_last, true.share_last) for said, true in shares]),
        refused=share(one.diagnosis is None for one in crowds),
        by_size={
            name: share(found(one, hidden, nested=True) for one, hidden, gain in effects if low <= gain < high)
            for name, (low, high) in BINS.items()
        },
        verdicts=dict(Counter(one.diagnosis.verdict for one in crowds if one.diagnosis is not None)),
        seconds=median([one.seconds for one in crowds]),
    )


def over_claimed(one: Answer, floor: float = 1.0) -> bool:
    """Whether more than the floor is left on the third log, on held-out data where there is none.

    Args:
        one: The case.
        floor: What counts as floor of the gap [1].
    """
    if one.third is not None and one.third.after is not None:
        return one.third.after > OVER * floor
    gap = None if one.diagnosis is None else one.diagnosis.gap
    return gap is not None and gap.after is not None and gap.after > OVER * floor


def crowd_sizes(answers: Sequence[Answer]) -> Iterator[FittedSize]:
    """List the sizes of rightly named effects of crowds whose nominal model is exact.

    Args:
        answers: The cases.
    """
    for one in crowds_of(answers):
        if one.truth.nuisance != "exact":
            continue
        for hidden in one.truth.deviations:
            name = COMPARABLE.get(hidden.effect, "")
            for cause in claimed(one):
                here = same_place(one.truth.robot, hidden.location, cause.location)
                if here and cause.effect == hidden.effect and name in cause.parameters:
                    yield FittedSize(one, name, cause.parameters[name], hidden.parameters[name], hidden)


def _whole(one: Answer, nested: bool = False) -> bool:
    right = (one.right(cause, nested=nested, placed=True) for cause in claimed(one))
    return complete(one, nested) and all(right)


def _effects(one: Answer) -> list[tuple[Deviation, float]]:
    known = library_effects(one.truth)
    return [pair for pair in zip(one.truth.deviations, one.truth.gains, strict=True) if pair[0] in known]


def _closed_truth(one: Answer) -> float | None:
    return None if one.crowd is None or one.crowd.third is None else one.crowd.third.closed_fraction


def _left_by_truth(one: Answer) -> float:
    """Return the gap of the third log with the true effects [1]; the floor where it was not measured."""
    third = None if one.crowd is None else one.crowd.third
    return 1.0 if third is None or third.after is None else max(third.after, 1.0)


def _shares(one: Answer) -> Iterator[tuple[BudgetShare, TrueShare]]:
    """Pair the stated shares of rightly named effects with the true ones."""
    if one.diagnosis is None or one.crowd is None:
        return
    for true in one.crowd.budget:
        for said in one.diagnosis.budget:
            here = same_place(one.truth.robot, true.location, said.location)
            if here and said.effect == true.effect:
                yield said, true


def _distance(said: float | None, true: float | None) -> float | None:
    return None if said is None or true is None else abs(said - true)
