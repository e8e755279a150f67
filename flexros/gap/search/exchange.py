"""Exchange: effects of an explanation for candidates that may do the same."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.delay import Delay
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.servos import ServoCommandLag
from flexros.gap.candidates.candidate import alike, simpler
from flexros.gap.fit.candidate_fit import best_of_each, first_parameters
from flexros.gap.search.elimination.reduce import reduced
from flexros.gap.search.fits.additions import begun_at
from flexros.gap.search.model_probability import contrast_of
from flexros.gap.search.worth import compared, in_vain, incomplete, simplest, worth
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.directions import Directions
    from flexros.gap.search.fits.additions import Addition
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.model_probability import ModelComparison


CLEARLY = 1e-3
"""Share by which an exchange lowers what is left of a measured log [1] (chosen)."""
AS_MUCH = 0.1
"""Relative difference of what two explanations leave up to which an exchange is not tried again [1] (chosen)."""
RICH = 3
"""Parameters from which a law that extends others may stand for two effects [1]."""


def exchanged(
    search: Search,
    fit: CandidateFit,
    directions: Sequence[Directions],
    fits: list[CandidateFit],
    shown: frozenset[str] | None = None,
) -> CandidateFit:
    """Exchange effects for candidates that may do the same, for as long as that improves the explanation.

    Args:
        search: The search.
        fit: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
        shown: Names of effects that are exchanged for those alone that torques take for them; default: those that
            torques show, or that replaced one of them.
    """
    settings = search.settings.search
    for _ in range(settings.rounds if len(fit.hypothesis) > 1 or search.resumed else 0):
        if search.deadline.stops():
            break
        exchanges = [
            (candidate, addition)
            for candidate, additions in _replacements(search, fit, directions, shown)
            for addition in additions[: settings.added]
            if not _was_in_vain(search, fit, candidate, addition)
        ]
        comparison, level = _compared(search, fit, exchanges, fits)
        early = [] if in_vain(search, fit) else [one for one in level if _stopped_early(search, fit, one)]
        if early:
            fits += search.parallel("effects exchanged", search.to_compare, early)
            comparison = compared(search, best_of_each(fits))
            level = [one for one in comparison.fits if len(one.hypothesis) == len(fit.hypothesis)]
        best = simplest(search, comparison, comparison.ranked(level)[0], level)
        if best.names == fit.names or not _better(search, comparison, fit, best):
            break
        fit = search.completed(best)
        fits.append(fit)
    return fit


def _better(search: Search, comparison: ModelComparison, fit: CandidateFit, other: CandidateFit) -> bool:
    """Return whether another explanation takes the place of one: it leaves less, or hardly more with fewer parameters.

    Of a measured log it must leave clearly less: laws that hardly act took turns for most of the time of a drive, each
    for less than a thousandth of what was left.
    """
    if search.premises.floor_is_noise:
        return other.chi2 <= fit.chi2 or comparison.score(other) > comparison.score(fit)
    fewer = other.predictor.n_effect < fit.predictor.n_effect
    return other.chi2 < (1 - CLEARLY) * fit.chi2 or (fewer and comparison.score(other) > comparison.score(fit))


def one_delay(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Replace filters of commands, or viscous friction, of servos by one delay of all, where that does as much.

    Which of them it is shows little beside what is still missing where the search begins: of a load that the file
    lacks, five filters of 18 to 19 ms took up more than a delay of 20 ms did, and with them wrong rotors. Viscous
    friction b makes a servo of the stiffness k late by b / k: beside a wrong gain, that of three motors by 4 ms each
    stood for a delay. No exchange of one effect for one comes from these to the delay. Filters may stand for a part of
    a delay that is there too. In place of that of one servo, of a leg whose others were not late enough to show, linear
    theory does not see the delay: it must leave less there.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; new ones are appended.
    """
    delay = next((one for one in search.candidates() if one.name == f"{Delay.name}@all"), None)
    if delay is None or search.data.record.command is None:
        return fit
    removed = search.settings.search.removed_of_all
    for times_of in (_by_filters, _by_friction):
        times = times_of(fit)
        own = {name: time for name, time in first_parameters(fit).items() if name == delay.name}
        alone = len(times) == 1
        if not times or (own and (alone or times_of is _by_friction)) or search.deadline.stops():
            continue
        begin = float(np.mean(list(times.values()))) + sum(own.values())
        late = _with_late_commands(search, fit, [*times, *own], [delay], begin)
        fits.append(late)
        if alone:
            fit = late if _better(search, compared(search, [late, fit]), fit, late) else fit
            continue
        late = reduced(search, late, fits, removed)
        fit = fit if worth(search, compared(search, [late, fit]), late, fit, removed) else late
    return fit


def _by_filters(fit: CandidateFit) -> dict[str, float]:
    """Return by which time filters of commands make servos late [s], by effect@location."""
    sizes = first_parameters(fit)
    return {one.name: sizes[one.name] for one in fit.hypothesis if one.effect is ServoCommandLag}


def _by_friction(fit: CandidateFit) -> dict[str, float]:
    """Return by which time viscous friction makes servos late [s], by effect@location."""
    sizes, numbers = first_parameters(fit), fit.predictor.robot.parameters
    own = [one for one in fit.hypothesis if one.effect is ViscousFriction and sizes[one.name] > 0]
    stiffness = {one.name: numbers[f"{one.location}.{SERVO}stiffness"].value for one in own}
    return {name: sizes[name] / value for name, value in stiffness.items() if value > 0}


def filters_for_delay(search: Search, fit: CandidateFit) -> CandidateFit | None:
    """Fit an explanation with filters of the commands of all servos in place of one delay of all.

    Args:
        search: The search.
        fit: The explanation.

    Returns:
        The fit; None without that delay, or where no filters compete.
    """
    lags = [one for one in search.candidates() if one.effect is ServoCommandLag and one.name not in fit.names]
    name, sizes = f"{Delay.name}@all", first_parameters(fit)
    return _with_late_commands(search, fit, [name], lags, sizes[name]) if lags and name in sizes else None


def _with_late_commands(
    search: Search, fit: CandidateFit, gone: Sequence[str], candidates: Sequence[Candidate], late: float
) -> CandidateFit:
    """Fit an explanation with other effects that make the commands of servos late.

    Args:
        search: The search.
        fit: The explanation.
        gone: Its own such effects, effect@location.
        candidates: The others.
        late: Time by which they begin [s].
    """
    sizes = [{free.name: late for free in one.free} for one in candidates]
    additions = [begun_at(one, own, fit, len(search.rows)) for one, own in zip(candidates, sizes, strict=True)]
    return search.completed(search.together(fit, additions, without=gone))


def _stopped_early(search: Search, fit: CandidateFit, other: CandidateFit) -> bool:
    """Return whether another fit with a plain effect in place of one comes near, but was not carried to its end.

    A fit ends early where linear theory sees no hope, with slopes to tolerated numbers that are not its own: delay and
    lag of a motor that differ by a nat at their minima seemed to be 16 nats apart. Of a search in vain such a
    difference decides nothing.

    Args:
        search: The search.
        fit: The explanation.
        other: The fit with an effect exchanged.
    """
    contrast = contrast_of(other.hypothesis, fit.hypothesis)
    near = other.chi2 - fit.chi2 < search.settings.search.little * search.data.n_values
    return not other.converged and near and contrast.between and contrast.plain and len(contrast.own) == 1


def corrected(
    search: Search, fit: CandidateFit, directions: Sequence[Directions], fits: list[CandidateFit]
) -> CandidateFit:
    """Exchange an effect for the candidate that does best in its place, where no torques show the first effects.

    The first effect of several stands for all of them, and a rich law does that best. Kept, it makes others imitate
    what it lacks. A simpler candidate at the same place comes first, else the best one counts; and two candidates whose
    gains add up stand against a law with as many parameters.

    Args:
        search: The search.
        fit: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
    """
    if search.torques_decide or len(fit.hypothesis) < 2 or search.deadline.stops():
        return fit
    exchanges = [
        (candidate, addition)
        for candidate, additions in _replacements(search, fit, directions)
        for addition in _simple_there_first(candidate, additions)[:1]
    ]
    comparison, level = _compared(search, fit, exchanges, fits)
    divisions = _divisions(search, fit, directions)
    divided = search.parallel("effects divided", lambda one: search.together(fit, one[1], without=(one[0],)), divisions)
    divided = search.visible(divided)
    fits += divided
    best = max([*level, *divided], key=comparison.score, default=fit)
    return best if comparison.score(best) > comparison.score(fit) else fit


def _divisions(search: Search, fit: CandidateFit, directions: Sequence[Directions]) -> list[tuple[str, list[Addition]]]:
    """List the rich laws that explain a simulated log, each with two candidates whose gains in its place add up."""
    settings, found = search.settings.search, []
    rich = [one for one in fit.hypothesis if len(one.free) >= RICH and one.effect.extends]
    if not search.premises.library_is_complete or not rich:
        return []
    for candidate, rest in zip(fit.hypothesis, search.removals(fit, search.surroundings(fit)), strict=True):
        additions = search.additions(directions, fit, rest)[: settings.screened] if candidate in rich else []
        if not additions:
            continue
        changes = np.stack([addition.change for addition in additions], axis=-1)
        group = [additions[index] for index in rest.independent(changes, 2, settings.kept)]
        if len(group) > 1:
            sizes = rest.sizes(np.stack([addition.change for addition in group], axis=-1))
            found.append((candidate.name, [one.sized(size) for one, size in zip(group, sizes, strict=True)]))
    return found


def _simple_there_first(candidate: Candidate, additions: Sequence[Addition]) -> list[Addition]:
    """Sort candidates so that those at the place of another one that have fewer parameters come first."""

    def later(addition: Addition) -> bool:
        one = addition.candidate
        return one.location != candidate.location or len(one.free) >= len(candidate.free)

    return sorted(additions, key=later)


def _replacements(
    search: Search, fit: CandidateFit, directions: Sequence[Directions], shown: frozenset[str] | None = None
) -> Iterator[tuple[Candidate, list[Addition]]]:
    """Yield effects with the candidates that may regain most of what is lost without them.

    Of those that torques show, relative errors compete with others at their motor, as the regression takes a wrong
    torque constant for an inertia, and a constant torque with a weight that is turned. In place of a harmonic of a
    simulated log the others of its order compete too.
    Where nothing is left, a law that contains the effect only adds parameters, and its fit takes the longest of all.
    """
    surroundings = search.surroundings(fit)
    shown = search.shown_by_torques(fit) if shown is None else shown
    for candidate, rest in zip(fit.hypothesis, search.removals(fit, surroundings), strict=True):
        competing = directions
        if candidate.effect.harmonics:
            competing = [*directions, *search.directions(search.harmonics_in_place(fit, candidate), fit)]
        if candidate.name in shown:
            competing = [one for one in directions if alike(one.candidate, candidate)]
        if competing:
            numbers, additions = search.settings.search, search.additions(competing, fit, rest)
            regaining = [one for one in additions if one.gain > numbers.regained * (rest.least - fit.chi2)]
            additions = [one for one in regaining if one.gain > rest.least - numbers.within_reach * fit.chi2]
            if not additions and len(candidate.free) >= RICH:  # a large change of few parameters is far from linear
                additions = [one for one in regaining[:1] if len(one.candidate.free) < len(candidate.free)]
            other = [addition for addition in additions if candidate.name not in simpler(addition.candidate)]
            nothing_left = len(other) < len(additions) and not incomplete(search, compared(search, [fit]), fit)
            yield candidate, other if nothing_left else additions


def _compared(
    search: Search, fit: CandidateFit, exchanges: Sequence[tuple[Candidate, Addition]], fits: list[CandidateFit]
) -> tuple[ModelComparison, list[CandidateFit]]:
    """Fit an explanation with each exchange; return the comparison of all fits, and those of as many effects."""
    plants = search.plants(fit, [addition.candidate for _, addition in exchanges])

    def exchange(pair: tuple[Candidate, Addition]) -> CandidateFit:
        candidate, addition = pair
        plant = plants[addition.candidate]
        return search.together(fit, [addition], without=(candidate.name,), plant=plant, rival=fit.chi2)

    fits += search.visible(search.parallel("effects exchanged", exchange, exchanges))
    comparison = compared(search, best_of_each(fits))
    level = [one for one in comparison.fits if len(one.hypothesis) == len(fit.hypothesis)]
    left = {one.names: one.chi2 for one in level}
    for candidate, addition in exchanges:
        other = fit.names - {candidate.name} | {addition.candidate.name}
        if left.get(other, np.inf) > fit.chi2:
            search.in_vain[candidate.name, addition.candidate.name] = fit.chi2
    return comparison, level


def _was_in_vain(search: Search, fit: CandidateFit, candidate: Candidate, addition: Addition) -> bool:
    """Return whether an exchange made an explanation of a measured log worse that left about as much.

    Later stages of a search come back to the explanation of an earlier one: of five servos 37 of 100 exchanges were
    fitted again, with the same result.
    """
    left = search.in_vain.get((candidate.name, addition.candidate.name), 0.0)
    return not search.premises.floor_is_noise and abs(left - fit.chi2) < AS_MUCH * fit.chi2
