"""Common factor: numbers of a servo that positions determine up to a factor alone, so that any one may be nominal."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.search.fits.additions import best_starts

if TYPE_CHECKING:
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.additions import Addition
    from flexros.gap.search.fits.candidate_fits import Search

ALIKE = 0.9
"""Squared correlation of two sizes, all others free, from which one may stand for the other [1] (chosen): 0.96 to 0.99
at a wrist without weight, at most 0.3 at joints with weight."""


def with_other_scales(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> None:
    """Fit an explanation of a log without torques with other numbers of a servo nominal, as rivals of it.

    At a joint that gravity does not load, gain, damping, inertia and friction have a common factor. With wrong friction
    and gain, the log is explained alike by a wrong gain and a wrong inertia, and the search ends with one of the two.

    Args:
        search: The search.
        chosen: The explanation, at its end.
        fits: All fits so far; new ones are appended.
    """
    if search.data.record.command is None or search.deadline.stops():
        return
    own = [one for one in chosen.hypothesis if one.name in search.of_torques]
    servos = {one.location for one in own}
    nominal = [one for one in search.candidates() if one.name in search.of_torques and one.location in servos]
    directions = search.directions([one for one in nominal if one.name not in chosen.names], chosen)
    around = search.surroundings(chosen)
    trials = []
    for one, rest in zip(chosen.hypothesis, search.removals(chosen, around), strict=True):
        for direction in directions:
            if one not in own or one.location != direction.candidate.location:
                continue
            change = direction.changes[:, best_starts(direction, rest, 1)[0]]
            if around.alike(int(np.argmax(chosen.columns((one.name,)))), change) > ALIKE:
                trials += [(one.name, addition) for addition in search.additions([direction], chosen, rest)]
    fits += search.visible(search.parallel("other scales", partial(_exchanged, search, chosen), trials))


def _exchanged(search: Search, chosen: CandidateFit, trial: tuple[str, Addition]) -> CandidateFit:
    """Fit an explanation with another effect in place of one of its own, to the end where it comes near."""
    name, addition = trial
    found = search.together(chosen, [addition], without=(name,), rival=chosen.chi2)
    near = found.chi2 - chosen.chi2 < search.settings.search.little * search.data.n_values
    return search.completed(found) if near else found
