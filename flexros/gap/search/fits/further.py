"""An explanation fitted with further candidates: in groups, and around the nominal numbers of the model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.torque_bias import TorqueBias
from flexros.gap.candidates.candidate import is_uneven
from flexros.gap.fit.limits import ended_at_last
from flexros.gap.search.worth import compared, worth

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.additions import Addition
    from flexros.gap.search.fits.candidate_fits import Search

USUAL = (CoulombFriction, ViscousFriction, TorqueBias)
"""What may be missing at every motor, as machines have it."""


def from_nominal_numbers(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit | None:
    """Add a candidate to an explanation of a simulated log that draws numbers of the model out of tolerance for it.

    These made up for what was missing, far from where linear theory around them sees what it would do: a gain of the
    torques that is 6 % off had become a spring that was 12 % too soft and seven other numbers, beside which it promised
    nothing. Around the numbers of the nominal model it promises most.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; new ones are appended.

    Returns:
        The best of the new fits; None where numbers are within tolerance or no candidate is left.
    """
    if not draws_numbers(search, fit):
        return None
    nominal = search.with_nominal_numbers(fit)
    directions = search.directions(search.candidates(), nominal)
    additions = search.additions(directions, nominal, search.surroundings(nominal))
    return fitted_with(search, nominal, [[one] for one in additions[: search.settings.search.added]], fits)


def with_usual(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit | None:
    """Add friction and constant torques at all motors to an explanation that draws numbers of the model for them.

    Beside the first effect of a crowd these numbers go to their limits, and what is proposed and fitted around them
    imitates: a ripple that stood for a constant torque could not be left out any more, as a fit without it went on from
    the same numbers. From the nominal ones all friction at once is found in one fit, and what is needless of it goes.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; the new one is appended.

    Returns:
        The new fit; None where numbers are within tolerance, or where it removes little of what is left.
    """
    usual = [one for one in search.candidates() if one.effect in USUAL and one.name not in fit.names]
    if not usual or not draws_numbers(search, fit):
        return None
    nominal = search.with_nominal_numbers(fit)
    around = search.surroundings(nominal)
    additions = search.additions(search.directions(usual, nominal), nominal, around)
    if not additions:
        return None
    sizes = around.sizes(np.stack([one.change for one in additions], axis=-1))
    sized = [one.sized(size) for one, size in zip(additions, sizes, strict=True)]
    grown = fitted_with(search, nominal, [sized], fits)
    enough = search.settings.search.removed
    return grown if grown is not None and compared(search, [fit, grown]).removed(fit, grown) > enough else None


def draws_numbers(search: Search, fit: CandidateFit) -> bool:
    """Return whether an explanation of a simulated log draws numbers out of tolerance, and there is time to mend it."""
    strained = search.premises.library_is_complete and compared(search, [fit]).beyond_tolerance(fit)
    return strained and not search.deadline.stops()


def fitted_with(
    search: Search, fit: CandidateFit, trials: Sequence[Sequence[Addition]], fits: list[CandidateFit]
) -> CandidateFit | None:
    """Fit an explanation with each of some groups of candidates; new fits are appended, the best one is returned."""
    together = search.parallel("effects together", lambda trial: search.together(fit, trial), trials)
    visible = search.visible([search.with_visible(one) for one in together])
    grown = [one for one in (_without_ended(search, fit, one) for one in visible) if one is not None]
    fits += grown
    return min(grown, key=lambda one: one.chi2, default=None)


def _without_ended(search: Search, fit: CandidateFit, grown: CandidateFit) -> CandidateFit | None:
    """Leave out further effects of a measured log that ended at the last limits of their search; None where all did.

    They are no findings. Beside one of them, a limit of torques that stood for the weight of a cable and the friction
    of the motor, effects were left out that could not come back when it was left out in the end.

    Args:
        search: The search.
        fit: The fit before.
        grown: The same with further effects.
    """
    further = grown.names - fit.names
    ended = further & ended_at_last(grown) if search.torques_decide else set()
    if ended == further:
        return None
    return search.without(grown, *ended) if ended else grown


def with_constant_torques(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Add a constant torque to a motor whose friction differs by direction, in a simulated log.

    A motion that favours one direction no more than the other tells the two apart by the speed alone. Without the
    constant torque the asymmetry takes up most of it, and a slow ripple the rest.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; new ones are appended.
    """
    uneven = {one.location for one in fit.hypothesis if is_uneven(one)}
    lacking = [
        one
        for one in search.candidates()
        if one.effect is TorqueBias and one.location in uneven and one.name not in fit.names
    ]
    if not search.premises.library_is_complete or not lacking or search.deadline.stops():
        return fit
    for addition in search.additions(search.directions(lacking, fit), fit, search.surroundings(fit)):
        beside = search.completed(search.together(fit, [addition]))
        if worth(search, compared(search, [fit, beside]), fit, beside, search.settings.search.removed):
            fits.append(beside)
            fit = beside
    return fit
