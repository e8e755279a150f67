"""Exchange: effects of an explanation for candidates that may do the same."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from flexros.gap.search.worth import compared, simplest, unique

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.fit.screening import Directions, Surroundings
    from flexros.gap.prediction.compiled_plant import CompiledPlant
    from flexros.gap.search.candidate_fits import Addition, Search


def exchanged(
    search: Search, fit: CandidateFit, directions: Sequence[Directions], fits: list[CandidateFit]
) -> CandidateFit:
    """Exchange effects for candidates that may do the same, for as long as that improves the explanation.

    Args:
        search: The search.
        fit: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
    """
    settings = search.settings.search
    for _ in range(settings.rounds if len(fit.hypothesis) > 1 else 0):
        if search.deadline.stops():
            break
        surroundings = search.surroundings(fit)
        pairs = [
            (candidate.name, addition)
            for candidate, rest in zip(fit.hypothesis, search.removals(fit, surroundings))
            if candidate.name not in search.base.names
            for addition in _replacements(search, fit, rest, directions)[: settings.added]
        ]
        plants = search.plants(fit, [addition.candidate for _, addition in pairs])
        exchange = partial(_exchange, search, fit, plants)
        fits += search.visible(search.parallel("effects exchanged", exchange, pairs))
        comparison = compared(search, unique(fits))
        level = [one for one in comparison.fits if len(one.hypothesis) == len(fit.hypothesis)]
        best = simplest(search, comparison, comparison.ranked(level)[0], level)
        if best.names == fit.names or best.chi2 > fit.chi2:
            break
        fit = search.completed(best)
        fits.append(fit)
    return fit


def corrected(
    search: Search, fit: CandidateFit, directions: Sequence[Directions], fits: list[CandidateFit]
) -> CandidateFit:
    """Exchange an effect for the candidate that does best in its place, in simulated logs.

    The first effect of several stands for all of them, and a rich law does that best. Kept, it makes others imitate
    what it lacks. A simpler candidate at the same place comes first, else the best one counts.

    Args:
        search: The search.
        fit: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
    """
    if search.base is not search.null.fit or len(fit.hypothesis) < 2 or search.deadline.stops():
        return fit
    surroundings = search.surroundings(fit)
    pairs = [
        (candidate.name, addition)
        for candidate, rest in zip(fit.hypothesis, search.removals(fit, surroundings), strict=True)
        for addition in _simple_there_first(candidate, _replacements(search, fit, rest, directions))[:1]
    ]
    plants = search.plants(fit, [addition.candidate for _, addition in pairs])
    exchange = partial(_exchange, search, fit, plants)
    fits += search.visible(search.parallel("effects exchanged", exchange, pairs))
    comparison = compared(search, unique(fits))
    level = [one for one in comparison.fits if len(one.hypothesis) == len(fit.hypothesis)]
    best = max(level, key=comparison.score, default=fit)
    return best if comparison.score(best) > comparison.score(fit) else fit


def _simple_there_first(candidate: Candidate, additions: Sequence[Addition]) -> list[Addition]:
    """Sort candidates so that those at the place of another one that have fewer parameters come first."""

    def later(addition: Addition) -> bool:
        one = addition.candidate
        return one.location != candidate.location or len(one.free) >= len(candidate.free)

    return sorted(additions, key=later)


def _exchange(
    search: Search, fit: CandidateFit, plants: Mapping[Candidate, CompiledPlant], pair: tuple[str, Addition]
) -> CandidateFit:
    """Fit an explanation with one candidate in place of one of its own."""
    name, addition = pair
    return search.together(fit, [addition], without=name, plant=plants[addition.candidate], rival=fit.chi2)


def _replacements(
    search: Search, fit: CandidateFit, rest: Surroundings, directions: Sequence[Directions]
) -> list[Addition]:
    """List the candidates that may regain most of what is lost without an effect."""
    lost = rest.least - fit.chi2
    additions = search.additions(directions, fit, rest)
    return [addition for addition in additions if addition.gain > search.settings.search.regained * lost]
