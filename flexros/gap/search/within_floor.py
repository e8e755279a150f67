"""Several effects within the floor of a measured log, none of which would be found there alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.fit.candidate_fit import first_parameters
from flexros.gap.search.elimination import one_by_one
from flexros.gap.search.growth import with_more
from flexros.gap.search.richer_laws import best_richer
from flexros.gap.search.worth import beyond_noise, compared

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.screening import Directions
    from flexros.gap.search.fits.candidate_fits import Search

RESIZED = 0.5
"""Change of the size of an effect, over the larger one, from which small effects beside it are none (chosen)."""


def grown_within_floor(
    search: Search,
    chosen: CandidateFit,
    directions: Sequence[Directions],
    fits: list[CandidateFit],
    richer: CandidateFit | None = None,
) -> CandidateFit:
    """Add effects on trial within the floor of a measured log, and keep those that are worth it in the end.

    The floor is the stated tolerance of torques. Within it an effect must leave less than half of what there is without
    it, as it does where the torques are known far better. Of several that are missing none does so before the others
    are there. So they are added for as long as each step removes a good part of what is left. Where little is left
    then, the needless ones are left out again, one by one, each judged with all others in place; where not, what is
    left is of another kind, and none of them is a finding. Nor are effects beside which those found before would have
    quite other sizes: with a vibration at the tool of an arm of three servos, a rotor that is 33 % larger than in the
    file was 76 % smaller, for a hundredth of the floor.

    Args:
        search: The search.
        chosen: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
        richer: The best explanation with a richer law in place of one of its own, see `best_richer`; None without one.
    """
    settings, ranking = search.settings.search, search.settings.ranking
    if search.premises.floor_is_noise or search.deadline.stops():
        return chosen
    if compared(search, [chosen]).level(chosen) > ranking.floors:
        return chosen
    if not beyond_noise(search, chosen) > settings.least_of_tolerance**2:
        return chosen  # no effect that is missing would be as large as one must be
    begin = trial = search.completed(chosen)
    tried: list[CandidateFit] = []
    for _ in range(settings.rounds_within_floor):
        if search.deadline.stops() or len(trial.hypothesis) >= settings.most_effects:
            break
        enough = (1 - settings.removed) * beyond_noise(search, trial)
        grown = richer if trial is begin else best_richer(search, trial, tried)
        if grown is None or not beyond_noise(search, grown) < enough:
            grown = with_more(search, trial, directions, tried, known=fits)
            if grown is None:
                break
            # slopes of the base lead numbers of the model astray where effects are many
            grown = search.completed(grown)
        if not beyond_noise(search, grown) < enough:
            break
        trial = grown
    most = settings.within_floor * beyond_noise(search, begin)
    if trial is begin or not beyond_noise(search, trial) < most:
        return chosen
    kept = one_by_one(search, trial, tried)
    if kept.names == chosen.names or not beyond_noise(search, kept) < most or _resized(begin, kept):
        return chosen
    fits += [fit for fit in (begin, trial, *tried) if fit.names <= trial.names]
    return kept


def _resized(before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether an effect of both fits has another sign in one of them, or less than half of its size."""
    sizes, others = first_parameters(before), first_parameters(after)
    return any(
        abs(sizes[name] - others[name]) > RESIZED * max(abs(sizes[name]), abs(others[name]))
        for name in sizes.keys() & others.keys()
    )
