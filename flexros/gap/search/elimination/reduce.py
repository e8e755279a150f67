"""Elimination: effects without which hardly more is left."""

from __future__ import annotations

from functools import partial
from math import log, log1p
from typing import TYPE_CHECKING

from flexros.gap.fit.candidate_fit import best_of_each
from flexros.gap.search.elimination.needless import all_at_once, needless_effects
from flexros.gap.search.worth import compared, more_than_chance, strains, worth

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search

STRAINED = 4
"""The least needed effects that are tried beside numbers out of tolerance, whatever linear theory says (chosen): an
imitation that stays attracts others. Every mode is tried too: springs and inertias take it over, far from its size."""

TRIED = 2
"""Effects without which an explanation is fitted at once (chosen): two that do the same compete."""

SEVERAL = 3
"""Needless effects from which they are left out at once (chosen): of two, two fits decide anyway."""


def reduced(search: Search, fit: CandidateFit, fits: list[CandidateFit], removed: float) -> CandidateFit:
    """Leave out the effects without which hardly more is left, one after the other, or several that are so together.

    Effects that are indispensable by linear theory are not tried, and those that seem least needed by it come first. An
    effect that gains less than its parameters cost is tried also where nothing is left above the floor, and so are the
    least needed ones of an explanation of a simulated log that draws numbers of the model out of tolerance.
    Without time for fits, and of the crowd of effects that torques show, all are left out at once that are needless by
    linear theory.

    Args:
        search: The search.
        fit: The fit.
        fits: All fits so far; new ones are appended.
        removed: Share of the remaining gap that every effect must remove [1].
    """
    settings = search.settings.search
    if not search.premises.floor_is_noise:
        removed = settings.removed_of_all
    certain = min(settings.indispensable, settings.certain * removed)
    at_once, whole = True, fit
    while len(fit.hypothesis) > 1:
        if search.torques_decide or search.deadline.stops_finishing():
            return _without_needless(search, fit, fits, removed)
        surroundings = search.surroundings(fit)  # of some rows: they tell how much is lost, not how much is left
        lost = [max(rest.least - surroundings.least, 0.0) for rest in search.removals(fit, surroundings)]
        doubt = partial(_is_doubtful, search, fit, certain)
        doubtful = [(rise, one.name) for one, rise in zip(fit.hypothesis, lost, strict=True) if doubt(rise, [one.name])]
        several = _doubtful_together(search, fit, [name for _, name in sorted(doubtful)], doubt) if at_once else ()
        if several:
            fits.append(search.without(fit, *several))
            at_once = not worth(search, compared(search, best_of_each(fits)), fits[-1], fit, removed)
            if at_once:
                fit = fits[-1]
                continue
        if search.premises.library_is_complete and compared(search, [fit]).beyond_tolerance(fit):
            # numbers of the model that an imitation drew out of tolerance go far without it: linear theory sees no end
            least = sorted((rise, one.name) for one, rise in zip(fit.hypothesis, lost, strict=True))
            modes = {one.name for one in fit.hypothesis if one.effect.stage == "structure"}
            tried = [pair for place, pair in enumerate(least) if place < STRAINED or pair[1] in modes]
            doubtful = [*doubtful, *(pair for pair in tried if pair not in doubtful)]
        rest = _without_one(search, fit, [name for _, name in sorted(doubtful)], fits, removed)
        if rest is None or _miss_together(search, whole, rest):
            break
        fit = rest
    return fit


def _miss_together(search: Search, whole: CandidateFit, rest: CandidateFit) -> bool:
    """Return whether several effects that were left out of a simulated log remove together what one must in the end.

    Each removes less than that of a rest that grows with every one that goes: beside an effect that no candidate
    explains four true ones went, which the search then found again and again.

    Args:
        search: The search.
        whole: The fit with all effects.
        rest: The fit without those that were left out.
    """
    if len(whole.hypothesis) - len(rest.hypothesis) < 2 or not search.premises.floor_is_noise:
        return False
    comparison = compared(search, [rest, whole])
    much = comparison.removed(rest, whole) >= search.settings.search.removed
    return much and more_than_chance(comparison, whole)


def _is_doubtful(search: Search, fit: CandidateFit, certain: float, rise: float, names: Sequence[str]) -> bool:
    """Return whether effects may be left out by linear theory.

    Args:
        search: The search.
        fit: The fit.
        certain: Share of what a fit without them leaves, from which they are indispensable [1].
        rise: Rise of the sum of squares without them [1].
        names: Their names.
    """
    return rise < certain * (rise + max(fit.chi2 - search.data.n_values, 0.0)) or _gain_nothing(
        search, fit, names, rise
    )


def _doubtful_together(
    search: Search, fit: CandidateFit, names: Sequence[str], doubt: Callable[[float, Sequence[str]], bool]
) -> Sequence[str]:
    """Return the most doubtful effects that are so together; none where they are few.

    Two that do the same are needed together, and are left to `_without_one`.

    Args:
        search: The search.
        fit: The fit.
        names: The effects that are doubtful alone, the most doubtful first.
        doubt: Whether effects are, by the rise of the sum of squares without them and by their names.
    """
    surroundings = search.surroundings(fit)
    sets = [names[:number] for number in range(SEVERAL, min(len(names), len(fit.hypothesis) - 1) + 1)]
    found: Sequence[str] = ()
    for tried, rest in zip(sets, search.removals_together(fit, surroundings, sets), strict=True):
        found = tried if doubt(max(rest.least - surroundings.least, 0.0), tried) else found
    return found


def _gain_nothing(search: Search, fit: CandidateFit, names: Sequence[str], rise: float) -> bool:
    """Return whether effects gain less than their parameters cost, by the rise of the sum of squares without them."""
    n, parameters = search.data.n_values, sum(len(one.free) for one in fit.hypothesis if one.name in names)
    return n * log1p(rise / fit.chi2) < compared(search, [fit]).threshold + parameters * log(n)


def _without_one(
    search: Search, fit: CandidateFit, names: Sequence[str], fits: list[CandidateFit], removed: float
) -> CandidateFit | None:
    """Leave out an effect without which hardly more is left, a few at a time being tried; None where there is none.

    Args:
        search: The search.
        fit: The fit.
        names: The effects that are tried, the most doubtful first.
        fits: All fits so far; new ones are appended.
        removed: Share of the remaining gap that every effect must remove [1].
    """
    for begin in range(0, len(names), TRIED):
        tried = names[begin : begin + TRIED]
        without = search.parallel("effects left out", partial(search.without, fit), tried, needed=TRIED)
        fits += without
        comparison = compared(search, best_of_each(fits))
        needless = [rest for rest in without if not worth(search, comparison, rest, fit, removed)]
        if needless:
            return min(needless, key=lambda rest: rest.chi2)
    return None


def _without_needless(search: Search, fit: CandidateFit, fits: list[CandidateFit], removed: float) -> CandidateFit:
    """Leave out the effects that are not worth their parameters by linear theory, but the best one.

    Of effects at the same motor that do much the same, such as Coulomb and viscous friction, each seems needless beside
    the others. So of those that torques show one at a motor is left out at a time, unless the time is over. Behind
    springs all go at once and compete again later: friction may drown there in the error of a spring, and one of its
    terms would stand for that. Where numbers of the model go far out of tolerance without several further effects, each
    is tried alone: one that is needed does not keep the others.

    Args:
        search: The search.
        fit: The fit.
        fits: All fits so far; new ones are appended.
        removed: Share of the remaining gap that every effect must remove [1].
    """
    kept: set[str] = set()
    alone = False
    while needless := [name for name in needless_effects(search, fit, removed) if name not in kept]:
        tried = needless[:1] if alone else needless
        fits.append(search.without(fit, *tried))
        further = set(tried) - search.shown_by_torques(fit)
        measured = search.from_torques
        if further and measured and _needed(search, fit, fits[-1], removed):
            # linear theory does not see what numbers of the model take over far from their tolerance, nor without which
            kept |= further if len(further) == 1 else set()
            alone = len(further) > 1 or alone
            continue
        fit = fits[-1]
        if all_at_once(search) and not alone:
            break
    return fit


def one_by_one(search: Search, fit: CandidateFit, fits: list[CandidateFit], most: float = float("inf")) -> CandidateFit:
    """Leave out the effects of a measured log that are not worth their parameters, each after a fit without it.

    Linear theory proposes them, the one that seems least needed first. Effects that torques show are left out where
    their size is not clear; of all others a fit decides. A quick one does where it leaves hardly more than with the
    effect, as a fit to the end leaves no more than that; only one that leaves much more is carried to its end. So is
    what is left before further effects are judged, where linear theory sees that it is no minimum yet.

    Args:
        search: The search.
        fit: The fit.
        fits: All fits so far; new ones are appended.
        most: Sum of squares from which no more is left out, as the result is of no use.
    """
    removed, kept = search.settings.search.removed_of_all, set[str]()
    while len(fit.hypothesis) > 1 and fit.chi2 <= most and not search.deadline.stops():
        needless = [name for name in needless_effects(search, fit, removed) if name not in kept]
        if not needless:
            break
        fits.append(search.without(fit, needless[0]))
        if needless[0] not in search.shown_by_torques(fit) and _missed(search, fit, fits[-1], removed):
            fits.append(search.completed(fits[-1]))
            if _missed(search, fit, fits[-1], removed):
                kept.add(needless[0])
                continue
        elif search.surroundings(fits[-1]).fall > max(search.settings.fit.enough, search.data.negligible):
            fits.append(search.completed(fits[-1]))
        fit = fits[-1]
    return fit


def _needed(search: Search, fit: CandidateFit, rest: CandidateFit, removed: float) -> bool:
    """Return whether effects are worth more than linear theory sees, or keep numbers of the model within tolerance."""
    return strains(search, compared(search, [rest]), fit, rest) or _missed(search, fit, rest, removed)


def _missed(search: Search, fit: CandidateFit, rest: CandidateFit, removed: float) -> bool:
    """Return whether the effects of a fit are worth more than those of another one that lacks some of them."""
    return worth(search, compared(search, [rest, fit]), rest, fit, removed)
