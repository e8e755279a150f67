"""Explanations of a measured log within its floor, which the held-out log tells apart."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.answer.decision import on_held_out
from flexros.gap.fit.candidate_fit import best_of_each
from flexros.gap.fit.limits import at_limits
from flexros.gap.held_out.closed_share import share_between
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.held_out.one_sample import surely_worse
from flexros.gap.search.exchange import exchanged, filters_for_delay
from flexros.gap.search.fits.additions import begun_at
from flexros.gap.search.worth import compared

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.held_out.errors_ahead import AheadErrors
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.model_probability import ModelComparison

RIVALS = 3
"""Other explanations that are tried, those that gain most in the fitted log less what they cost [1] (chosen)."""


def told_apart(search: Search, chosen: CandidateFit, fits: list[CandidateFit], held: FitData) -> CandidateFit:
    """Add to an explanation of a measured log within its floor what both logs are for, or exchange it.

    Within the tolerance of torques the fitted log does not count for an effect against what makes up for it there:
    friction that falls with speed against Coulomb friction, a gain of a servo against its damping and a rotor, filters
    of commands against one delay. Another motion does not confirm what makes up. Fits with further effects than the
    chosen ones are there from the search. One must leave less of the fitted log by more than its parameters cost, and
    remove as much of what the chosen one leaves of the held-out log as an effect must elsewhere, by more than chance.
    So must each of its further effects beside the others.

    Args:
        search: The search.
        chosen: The explanation.
        fits: All fits; new ones are appended, and those with what gave way are left out.
        held: The held-out log.
    """
    if search.premises.library_is_complete or search.deadline.stops():
        return chosen
    comparison = compared(search, best_of_each([*fits, chosen]))
    if comparison.level(chosen) > search.settings.ranking.floors:
        return chosen
    gain, data = partial(_gain, search, comparison, chosen), _HeldOut(search, held, errors_ahead(chosen, held))
    more = [fit for fit in comparison.fits if fit.names > chosen.names]
    better = sorted((fit for fit in more if gain(fit) > comparison.threshold), key=gain, reverse=True)
    for fit in better[:RIVALS]:
        whole = search.completed(fit)
        if data.confirms(chosen, whole):
            needed = data.needed_of(whole, chosen.names)
            if needed is not None and not at_limits(needed):
                chosen = needed
                break
    return _with_filters(search, chosen, fits, held)


@dataclass(frozen=True, eq=False)
class _HeldOut:
    """What the held-out log says of explanations.

    Attributes:
        search: The search.
        data: The log.
        left: What the chosen explanation leaves of it 0.1 s ahead.
    """

    search: Search
    data: FitData
    left: AheadErrors

    def confirms(self, rest: CandidateFit, fit: CandidateFit) -> bool:
        """Return whether a fit removes as much of what is left as an effect must, against another one.

        Where servos rest, coarse encoders err less than their noise says. What is left within that counts as a whole.
        """
        more, less = (errors_ahead(one, self.data) for one in (rest, fit))
        share_of = partial(share_between, self.left, more, less, self.data.record.sample_time)
        share = share_of() or share_of(floor=0.0)
        if share is None or share.value < self.search.settings.search.removed_of_all or share.interval[0] <= 0:
            return False
        return on_held_out(fit, self.data).chi2 <= on_held_out(rest, self.data).chi2

    def needed_of(self, whole: CandidateFit, known: Collection[str]) -> CandidateFit | None:
        """Leave out what the log does not confirm beside the others, all of it at once where none of it is needed.

        Args:
            whole: The explanation.
            known: Names of its effects that stay.

        Returns:
            The rest, each of whose further effects is confirmed; None without one, or where the time does not suffice.
        """
        search = self.search

        def without(name: str) -> tuple[str, CandidateFit]:
            return name, _without(search, whole, name)

        while (names := sorted(whole.names.difference(known))) and not search.deadline.stops():
            rests = dict(search.parallel("effects on held-out data", without, names))
            needless = {name: rest for name, rest in rests.items() if not self.confirms(rest, whole)}
            if not needless and len(rests) == len(names):
                return whole
            if len(needless) > 1 and not search.deadline.stops():
                rest = _without(search, whole, *needless)
                if not self.confirms(rest, whole):
                    whole = rest
                    continue
            whole = min(needless.values(), key=lambda rest: rest.chi2, default=whole)
        return None


def _with_filters(search: Search, chosen: CandidateFit, fits: list[CandidateFit], held: FitData) -> CandidateFit:
    """Take filters of the commands of servos in place of one delay of all, where both logs are for them.

    What stood for their difference may end at limits beside them: it gives way to what does as much in its place,
    unless the held-out log is surely predicted worse than before.

    Args:
        search: The search.
        chosen: The explanation.
        fits: All fits; new ones are appended, and those with what gave way are left out.
        held: The held-out log.
    """
    whole = None if search.deadline.stops() else filters_for_delay(search, chosen)
    if whole is None:
        return chosen
    comparison, data = compared(search, [chosen, whole]), _HeldOut(search, held, errors_ahead(chosen, held))
    if _gain(search, comparison, chosen, whole) <= comparison.threshold or not data.confirms(chosen, whole):
        return chosen
    needed = data.needed_of(whole, chosen.names)
    if needed is None:
        return chosen
    tried = [needed]
    if at_limits(needed):
        directions = search.directions(search.candidates(), needed)
        other = exchanged(search, needed, directions, tried)
        needed = needed if surely_worse(other, chosen, held) else other
    if at_limits(needed):
        return chosen
    rivals, gone = _rivals_beside(search, chosen, needed, fits), chosen.names - needed.names
    fits[:] = [fit for fit in [*fits, *tried, *rivals] if gone.isdisjoint(fit.names)]
    return needed


def _rivals_beside(
    search: Search, before: CandidateFit, after: CandidateFit, fits: Sequence[CandidateFit]
) -> list[CandidateFit]:
    """Exchange the same in likely rivals of an explanation, as the fitted log may not tell them apart still.

    Args:
        search: The search.
        before: The explanation.
        after: The same with effects exchanged.
        fits: All fits.
    """
    comparison = compared(search, best_of_each([*fits, before]))
    as_many = [fit for fit in comparison.fits if len(fit.hypothesis) == len(before.hypothesis)]
    gone, own = before.names - after.names, after.names - before.names
    stated = zip(after.hypothesis, after.predictor.values(after.theta), strict=True)
    exchanged_for = [(one, values) for one, values in stated if one.name in own]
    found = []
    for rival, probability in zip(as_many, comparison.probabilities(as_many), strict=True):
        likely = probability > search.settings.ranking.likely and rival.names != before.names
        if likely and gone <= rival.names and own.isdisjoint(rival.names):
            additions = [begun_at(one, values, rival, len(search.rows)) for one, values in exchanged_for]
            found.append(search.completed(search.together(rival, additions, without=gone)))
    return found


def _without(search: Search, fit: CandidateFit, *names: str) -> CandidateFit:
    return search.completed(search.without(fit, *names))


def _gain(search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> float:
    """Return the gain of a fit over another one less the cost of its parameters, wherever the floor is [1]."""
    n, cost = search.data.n_values, comparison.penalty(after) - comparison.penalty(before)
    return float(n * np.log(before.chi2 / after.chi2)) - cost
