"""Effects that are kept, taken back or left out by how clear their sizes are beside the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.candidates.candidate import ASYMMETRY, alike, is_uneven
from flexros.gap.fit.estimates import clearness, parameters_of, sizes_of
from flexros.gap.search.elimination.reduce import reduced
from flexros.gap.search.worth import compared, more_than_chance

if TYPE_CHECKING:
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search


def with_asymmetry(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Free the asymmetry of friction that torques show, and keep it where it is clear.

    Args:
        search: The search.
        fit: The effects that torques show, each with its size alone, and further ones.
        fits: All fits so far; a new one is appended.
    """
    whole = {candidate.name: candidate for candidate in search.candidates()}
    every = tuple(whole.get(candidate.name, candidate) for candidate in fit.hypothesis)
    if not any(is_uneven(candidate) for candidate in every):
        return fit
    found = parameters_of(search.reshaped(fit, every), search.data)
    clear = search.settings.search.clear_asymmetry
    kept = tuple(
        wide if is_uneven(wide) and abs(sizes[ASYMMETRY].value) > clear * sizes[ASYMMETRY].std else narrow
        for wide, narrow, sizes in zip(every, fit.hypothesis, found, strict=True)
    )
    if kept == fit.hypothesis:
        return fit
    fits.append(search.reshaped(fit, kept))
    return fits[-1]


def with_dropped(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Add the effects of the torques that were left out, then asymmetry, and keep what is clear now.

    Friction drowned in what another effect leaves, such as that of a wrong spring, shows once that effect is found.
    Friction whose mean is nominal may have an asymmetry that another effect imitates, which is needless then. One that
    was exchanged for what looks alike in torques, such as a constant torque for a wrong zero, was not left out.

    Args:
        search: The search.
        fit: An explanation with further effects than the torques show.
        fits: All fits so far; new ones are appended.
    """
    left_out = [candidate for candidate in search.base.hypothesis if candidate.name not in fit.names]
    dropped = [one for one in left_out if not any(alike(one, other) for other in fit.hypothesis)]
    directions = search.directions(dropped, fit)
    if not directions or search.deadline.stops():
        return fit
    additions = search.additions(directions, fit, search.surroundings(fit))
    fits.append(search.together(fit, additions))
    return reduced(search, with_asymmetry(search, fits[-1], fits), fits, search.settings.search.removed_by_step)


def with_dropped_again(
    search: Search, before: CandidateFit, chosen: CandidateFit, fits: list[CandidateFit]
) -> CandidateFit:
    """Judge the effects of the torques that were left out once more, beside those that were found since.

    Beside what was missing before, their sizes were not clear. None comes back alone: of Coulomb and viscous friction
    at a motor each promises little without the other one, and a law that stood for both may be in their place.

    Args:
        search: The search.
        before: The explanation when they were judged last.
        chosen: The explanation now.
        fits: All fits so far; new ones are appended.
    """
    if not search.torques_decide or chosen.names <= before.names:
        return chosen
    again = with_dropped(search, chosen, fits)
    if again.names == chosen.names:
        return chosen
    fits.append(search.completed(again))
    return fits[-1]


def without_unclear(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Leave out effects of a simulated log whose size is not clear, where noise alone is left without them.

    Of some hundred candidates, a few gain more than their parameters cost by chance, or from a millionth of the gap
    that the form of large effects leaves: beside a gap of 1e7 nats a spring that bends by 2e-5 of its stiffness gained
    25. What its deviation says, with errors of form, is that it may be zero.

    Args:
        search: The search.
        fit: The explanation, at its end.
        fits: All fits so far; new ones are appended.
    """
    comparison, needed = compared(search, [fit]), set[str]()
    if not search.premises.library_is_complete or more_than_chance(comparison, fit):
        return fit
    while len(fit.hypothesis) > 1 and not search.deadline.stops_finishing():
        clear_by = {name: clear for name, clear in _clear_by(search, fit).items() if name not in needed}
        least = min(clear_by, key=clear_by.__getitem__, default="")
        if not least or clear_by[least] >= search.settings.search.clear:
            break
        fits.append(search.completed(search.without(fit, least)))
        if more_than_chance(comparison, fits[-1]):
            needed.add(least)
        else:
            fit = fits[-1]
    return fit


def unclear(search: Search, fit: CandidateFit, least: float) -> list[str]:
    """Return the effects of a fit of which no size, with errors of form, is clearly not zero.

    Args:
        search: The search.
        fit: The fit.
        least: Size over its standard deviation from which it is clear [1].
    """
    return [name for name, clear in _clear_by(search, fit).items() if clear < least]


def _clear_by(search: Search, fit: CandidateFit) -> dict[str, float]:
    """Return by how many standard deviations, with errors of form, the size of each effect of a fit is not zero [1]."""
    found = zip(fit.hypothesis, parameters_of(fit, search.data, search.settings.ranking), strict=True)
    return {one.name: clearness(sizes[free.name] for free in sizes_of(one)) for one, sizes in found}
