"""Several effects of a measured log that hide each other, none of which would be found alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.gap.fit.candidate_fit import first_parameters
from flexros.gap.search.elimination.reduce import one_by_one
from flexros.gap.search.growth import with_more
from flexros.gap.search.regrouping import with_gains
from flexros.gap.search.richer_laws import best_richer
from flexros.gap.search.worth import beyond_noise, compared, turned_in_torques, worth

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.directions import Directions
    from flexros.gap.search.fits.candidate_fits import Search

RESIZED = 0.5
"""Change of the size of an effect, over the larger one, from which small effects beside it are none (chosen), and from
which it stood for others that are there now."""
TO_FLOOR = 0.8
"""Share of what is left above the floor that effects added on trial must remove together [1] (chosen)."""


def grown_to_floor(
    search: Search, chosen: CandidateFit, directions: Sequence[Directions], fits: list[CandidateFit]
) -> CandidateFit:
    """Add effects on trial above the floor of an arm with springs, and keep them where they lead within it together.

    Of several effects that hide each other behind springs each removes less than it must before the others are there: a
    wrong spring, a wrong rotor and friction change the same vibration. Where all of them leave what an explanation may,
    and little of what was left, they are no imitations of something unknown, of which much would remain. On six axes
    without springs twenty imitations in a row did not lead there, and took most of the time.

    Args:
        search: The search.
        chosen: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
    """
    floors = search.settings.ranking.floors
    if search.premises.floor_is_noise or search.null.model.robot.is_rigid:
        return chosen
    if search.deadline.stops() or not _level(search, chosen) > floors:
        return chosen
    begin = search.completed(chosen)

    def above_floor(fit: CandidateFit) -> float:
        return _level(search, fit) - 1.0

    def leads_there(fit: CandidateFit) -> bool:
        return _level(search, fit) <= floors and above_floor(fit) <= (1 - TO_FLOOR) * above_floor(begin)

    least = search.settings.search.least_on_trial
    trial = _grown_on_trial(search, begin, directions, above_floor, least, known=fits, hidden=True)
    return _kept(search, chosen, trial, leads_there, fits)


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
    left is of another kind, and none of them is a finding.

    Behind springs, gains that are wrong at both motors became two rotors, friction, and a load, and showed no earlier
    than beside the effects that were added: beside them fewer effects with gains leave less than all before.

    Args:
        search: The search.
        chosen: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
        richer: The best explanation with a richer law in place of one of its own, see `best_richer`; None without one.
    """
    settings = search.settings.search
    if search.premises.floor_is_noise or search.deadline.stops():
        return chosen
    if _level(search, chosen) > search.settings.ranking.floors:
        return chosen

    def left(fit: CandidateFit) -> float:
        return beyond_noise(search, fit)

    if not left(chosen) > settings.least_of_tolerance**2:
        return chosen  # no effect that is missing would be as large as one must be
    begin = search.completed(chosen)
    trial = _grown_on_trial(search, begin, directions, left, settings.removed, known=fits, richer=richer)
    most = settings.within_floor * left(begin)
    if left(trial.end) < most and not search.null.model.robot.is_rigid:
        gains = with_gains(search, trial.end, trial.tried, begin)
        if gains is not trial.end:
            fits += [begin, gains]
            return grown_within_floor(search, gains, directions, fits)
    return _kept(search, chosen, trial, lambda fit: left(fit) < most, fits)


def with_slant(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Add a slant of the base to an explanation of measured torques beside which these show it.

    The regression that the search begins with lacks ripples and friction at low speed, beside which a slant is not
    clear there. Numbers within their tolerance and other effects take up a part of it each, so that as a further effect
    it removes too little of what is left: a slant of 2.3 deg of an arm of six joints had removed a fifth.

    Args:
        search: The search.
        chosen: The explanation.
        fits: All fits so far; new ones are appended.
    """
    slants = [one for one in search.slants() if one.name not in chosen.names]
    if not slants or search.deadline.stops():
        return chosen
    around = search.surroundings(chosen)
    found = search.additions(search.directions(slants, chosen), chosen, around)
    if not found:
        return chosen
    slanted = search.completed(search.together(chosen, found[:1]))
    fits.append(slanted)
    if not turned_in_torques(search, chosen, slanted):
        return chosen
    removed = search.settings.search.removed_of_all
    return slanted if worth(search, compared(search, [chosen, slanted]), chosen, slanted, removed) else chosen


@dataclass(frozen=True, eq=False)
class _Trial:
    """Effects added on trial.

    Attributes:
        begin: The explanation before, fitted to the end.
        end: With all of them; the same one where none was added.
        last: With those of the last step too, whether that removed enough or not.
        tried: All fits on the way; those of what follows are appended.
    """

    begin: CandidateFit
    end: CandidateFit
    last: CandidateFit
    tried: list[CandidateFit]


def _kept(
    search: Search,
    chosen: CandidateFit,
    trial: _Trial,
    enough: Callable[[CandidateFit], bool],
    fits: list[CandidateFit],
) -> CandidateFit:
    """Return what of the effects that were added on trial is needed; the explanation before where that is not enough.

    The held-out log may still be for some of them, see `flexros.gap.answer.told_apart`.

    Behind springs, effects found before that have quite other sizes beside the new ones stood for them, and are left
    out first, unless they are worth it still. Without springs such new ones are none: with a vibration at the tool of
    an arm of three servos, a rotor that is 33 % larger than in the file was 76 % smaller, for a hundredth of the floor.

    Args:
        search: The search.
        chosen: The explanation before.
        trial: The effects.
        enough: Whether a fit leaves little enough.
        fits: All fits so far; new ones are appended.
    """
    if trial.end is trial.begin or not enough(trial.end):
        fits += [fit for fit in (trial.last,) if fit is not trial.begin]
        return chosen
    rigid, end = search.null.model.robot.is_rigid, trial.end
    if not rigid:
        end = _without_imitations(search, trial.begin, end, trial.tried)
    kept = one_by_one(search, end, trial.tried)
    if kept.names == chosen.names or not enough(kept) or (rigid and _resized(trial.begin, kept)):
        return chosen
    fits += [fit for fit in (trial.begin, trial.end, *trial.tried) if fit.names <= trial.end.names]
    return kept


def _grown_on_trial(
    search: Search,
    begin: CandidateFit,
    directions: Sequence[Directions],
    left: Callable[[CandidateFit], float],
    least: float,
    *,
    known: Sequence[CandidateFit],
    richer: CandidateFit | None = None,
    hidden: bool = False,
) -> _Trial:
    """Add effects for as long as each step removes a share of what is left, a richer law first.

    Args:
        search: The search.
        begin: The explanation, fitted to the end.
        directions: All candidates but those of harmonics.
        left: What a fit leaves [1].
        least: The share [1].
        known: Earlier fits.
        richer: As for `grown_within_floor`.
        hidden: Whether effects are sought that hide each other above the floor: each candidate must remove that share
            too, and steps remove more and more. What imitates something unknown removes less and less, and ends it.
    """
    settings, trial, last = search.settings.search, begin, begin
    tried: list[CandidateFit] = []
    removed = 0.0
    for _ in range(settings.rounds_on_trial):
        if not left(trial) > 0 or search.deadline.stops() or len(trial.hypothesis) >= settings.most_effects:
            break
        enough = (1 - least) * left(trial)
        grown = richer if trial is begin and richer is not None else best_richer(search, trial, tried)
        if grown is None or not left(grown) < enough:
            grown = with_more(search, trial, directions, tried, known=known, least=least if hidden else None)
            if grown is None:
                break
            # slopes of the base lead numbers of the model astray where effects are many
            grown = search.completed(grown)
        last = grown
        if not left(grown) < enough:
            break
        before, removed = removed, 1 - left(grown) / left(trial)
        trial = grown
        if hidden and removed < before:
            break
    return _Trial(begin, trial, last, tried)


def _without_imitations(
    search: Search, before: CandidateFit, after: CandidateFit, fits: list[CandidateFit]
) -> CandidateFit:
    """Leave out effects of an explanation that have less than half of their size now, unless they are worth it.

    Args:
        search: The search.
        before: The explanation.
        after: The same with further effects.
        fits: All fits on the way; new ones are appended.
    """
    removed = search.settings.search.removed_of_all
    for name in _resized(before, after):
        if search.deadline.stops():
            break
        rest = search.completed(search.without(after, name))
        fits.append(rest)
        if not worth(search, compared(search, [rest, after]), rest, after, removed):
            after = rest
    return after


def _resized(before: CandidateFit, after: CandidateFit) -> list[str]:
    """List the effects of both fits that have another sign in one of them, or less than half of their size."""
    sizes, others = first_parameters(before), first_parameters(after)
    return [
        name
        for name in sizes
        if name in others and abs(sizes[name] - others[name]) > RESIZED * max(abs(sizes[name]), abs(others[name]))
    ]


def _level(search: Search, fit: CandidateFit) -> float:
    return compared(search, [fit]).level(fit)
