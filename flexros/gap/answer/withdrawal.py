"""Effects that are withdrawn, as the held-out log is predicted better without them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import effects
from flexros.gap.answer.decision import level_of_positions, on_held_out
from flexros.gap.answer.rivals.most_probable import most_probable
from flexros.gap.answer.strained_numbers import STRAINED, far_out
from flexros.gap.answer.told_apart import told_apart
from flexros.gap.candidates.candidate import simpler
from flexros.gap.fit.candidate_fit import best_of_each
from flexros.gap.fit.estimates import beyond_search
from flexros.gap.fit.limits import at_limits, numbers_at_limits
from flexros.gap.fit.null_fit import predicting_best
from flexros.gap.fit.tolerance_takeover import with_own_numbers
from flexros.gap.held_out.closed_share import NOTHING, closed_fraction, share_between
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.held_out.gap_floor import tolerance_floor
from flexros.gap.held_out.one_sample import surely_worse
from flexros.gap.search.elimination.clear_sizes import unclear
from flexros.gap.search.forward_selection import explanations_of
from flexros.gap.search.worth import compared
from flexros.robot.parameters import DAMPER

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.held_out.closed_share import ClosedShare
    from flexros.gap.held_out.errors_ahead import AheadErrors
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.forward_selection import Explanations
    from flexros.gap.search.model_probability import ModelComparison

SAME = 1e-3
"""Share by which predictions of one sample may be worse and still count as the same [1] (chosen)."""
CLEAR = 3.0
"""Size of an effect that torques show over its standard deviation, with errors of form, from which it is clear [1]
(chosen)."""
RIVALS = 3
"""Other explanations that are tried once an effect was withdrawn, the likeliest ones [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class Confirmed:
    """Explanations of a fitted log, and what the held-out one took out of the chosen one.

    Attributes:
        explanations: The explanations, with the confirmed one chosen.
        withdrawn: Effects, effect@location, without which the held-out log is predicted better.
        fitted_around: Effects at the last limit of their search, the others fitted again without them for that reason.
    """

    explanations: Explanations
    withdrawn: tuple[str, ...] = ()
    fitted_around: tuple[str, ...] = ()


def confirmed(search: Search, explanations: Explanations, held: FitData) -> Confirmed:
    """Withdraw effects without which the held-out log is predicted better, one after the other.

    On a real machine no law has exactly the form of the library. A size that gains in the fitted log may make up for
    that there, as a gain of a servo does for friction that depends on the position, and spoil what is predicted of
    another motion. An effect is withdrawn where, with all others fitted again without it, the predictions 0.1 s ahead
    are better by more than chance, clearly so unless the effect closes nothing beside the others and is none that the
    torques show clearly, such as friction, and those of one sample are not worse by more than chance. One whose size is
    not determined, with errors of form, or of a spring whose damping is not, or that another effect contains, is also
    withdrawn where they are no worse. A simulated log has no such errors of form. One that comes back as a number of
    the model far out of its tolerance is not withdrawn: the fitted log needs it.

    Where the nominal model leaves no more than noise and tolerance in either log, there is no gap that an effect could
    be the cause of: one that does not hold in the held-out log is chance, however much it gains in the fitted one. So
    are effects that improve nothing there, and where none was found in the fitted one, the held-out one adds none.

    Args:
        search: The search.
        explanations: All fits, and the chosen one.
        held: The held-out log.
    """
    if _of_chance(search, explanations, held):
        return Confirmed(explanations_of(search, explanations.comparison, explanations.null, detected=False))
    fits = list(explanations.comparison.fits)
    no_gap = not explanations.detected and errors_ahead(explanations.null, held).mean <= search.settings.ranking.floors
    chosen = explanations.chosen if no_gap else told_apart(search, explanations.chosen, fits, held)
    if chosen is not explanations.chosen:
        fewer, others = explanations.chosen.names, best_of_each(fits)  # neither it nor what else has more was confirmed
        fits = [chosen, *(fit for fit in others if fit.names != chosen.names and not fit.names >= fewer)]
        explanations = explanations_of(search, compared(search, fits), chosen, detected=True)
    withdrawn: list[str] = []
    before: AheadErrors | None = None
    while not (search.premises.library_is_complete or search.deadline.stops()):
        better = None
        if len(chosen.hypothesis) > 1:
            if before is None:
                stop = search.deadline.of_fit(finishing=True)
                before = errors_ahead(predicting_best(explanations.null, search.data, stop), held)
            better = _better_without(search, chosen, before, held)
        if better is not None:
            withdrawn += chosen.names - better.names
        elif withdrawn:
            better = _rival(search, chosen, fits, withdrawn, held)
        if better is None:
            break
        fits.append(better)
        chosen = better
    found, rest = chosen, _without_limited(search, chosen, held)
    chosen = with_own_numbers(search.at_its_end(rest), search.data, STRAINED)
    if withdrawn or chosen is not found:
        fits = [chosen, *(fit for fit in fits if fit is not found)]
        kept = [fit for fit in fits if fit is chosen or (fit.names != chosen.names and fit.names.isdisjoint(withdrawn))]
        comparison = compared(search, best_of_each(kept))
        explanations = explanations_of(search, comparison, chosen, detected=True)
    if _improves_nothing(search, explanations, held):
        return Confirmed(explanations_of(search, explanations.comparison, explanations.null, detected=False))
    explanations = most_probable(search, explanations, held)
    return Confirmed(explanations, tuple(withdrawn), tuple(sorted(found.names - rest.names)))


def _without_limited(search: Search, chosen: CandidateFit, held: FitData) -> CandidateFit:
    """Fit an explanation of a measured log again without effects at the last limits of their search, if that is better.

    They are no findings and no part of the patch. Left out of a fit that leans on them, they had made a leg worse than
    its nominal model is.

    Args:
        search: The search.
        chosen: The explanation.
        held: The held-out log.
    """
    limited = beyond_search(chosen)
    if search.premises.library_is_complete or not limited or limited == chosen.names or search.deadline.stops():
        return chosen
    rest = search.completed(search.without(chosen, *limited))
    left_out = replace(chosen, theta=chosen.switched_off(limited))
    better = errors_ahead(rest, held).mean < errors_ahead(left_out, held).mean
    return rest if better and not beyond_search(rest) else chosen


def _rival(
    search: Search,
    chosen: CandidateFit,
    fits: Sequence[CandidateFit],
    withdrawn: Collection[str],
    held: FitData,
) -> CandidateFit | None:
    """Return a more probable explanation that leaves less of both logs than what is left of the chosen one, if any.

    What was withdrawn may have taken the place of a true effect: friction that drove a motor stood for a stiff servo.

    Args:
        search: The search.
        chosen: What is left of the explanation.
        fits: All fits.
        withdrawn: Effects that do not hold in the held-out log.
        held: The held-out log.
    """
    comparison = compared(search, best_of_each(fits))
    others = [fit for fit in comparison.fits if fit.names.isdisjoint(withdrawn) and not at_limits(fit)]
    others = [fit for fit in others if not any(comes_back(name, fit) for name in withdrawn)]
    better = [fit for fit in others if comparison.score(fit) > comparison.score(chosen) + comparison.threshold]
    better = [fit for fit in better if _more_probable(comparison, fit, chosen)]
    if not better:
        return None
    ahead, squares = errors_ahead(chosen, held).mean, on_held_out(chosen, held).chi2
    for fit in comparison.ranked(better)[:RIVALS]:
        if errors_ahead(fit, held).mean < ahead and on_held_out(fit, held).chi2 <= squares:
            return search.completed(fit)
    return None


def _more_probable(comparison: ModelComparison, fit: CandidateFit, other: CandidateFit) -> bool:
    """Return whether a fit is the more probable one of two, with errors of form."""
    first, second = comparison.probabilities([fit, other])
    return bool(first > second)


def _of_chance(search: Search, explanations: Explanations, held: FitData) -> bool:
    """Return whether effects were found without a gap in either log, and the held-out one is not predicted better."""
    null, chosen = explanations.null, explanations.chosen
    if not _hardly_a_gap(search, explanations, held):
        return False
    before = errors_ahead(null, held).mean
    if before > search.settings.ranking.floors:
        return False
    worse = on_held_out(chosen, held).chi2 >= on_held_out(null, held).chi2
    return worse or errors_ahead(chosen, held).mean > before


def _improves_nothing(search: Search, explanations: Explanations, held: FitData) -> bool:
    """Return whether effects improve no predictions of a held-out log, and torques within tolerance explain both logs.

    Errors of torques last, and 0.1 s ahead they leave far more than the floor: `tolerance_floor`.
    """
    null, floors = explanations.null, search.settings.ranking.floors
    if not _hardly_a_gap(search, explanations, held):
        return False
    before = errors_ahead(null, held)
    closed = closed_fraction(before, errors_ahead(explanations.chosen, held), held.record.sample_time)
    if closed is None or closed.interval[0] > 0:
        return False
    logs = ((before, held), (errors_ahead(null, search.data), search.data))
    return all(errors.mean <= floors * (tolerance_floor(null, log) or 1.0) for errors, log in logs)


def _hardly_a_gap(search: Search, explanations: Explanations, held: FitData) -> bool:
    """Return whether effects were found although predictions of one sample show no gap in either log."""
    if search.premises.floor_is_noise or not explanations.detected:
        return False
    null = explanations.null
    levels = level_of_positions(null, search.data), on_held_out(null, held).chi2 / held.n_values
    return max(levels) <= search.settings.ranking.floors


def _better_without(search: Search, chosen: CandidateFit, before: AheadErrors, held: FitData) -> CandidateFit | None:
    """Fit an explanation without the effect that spoils the predictions of the held-out log most; None without one.

    Those whose sizes are not determined are left out where they gain nothing by them, all at once where they gain
    nothing by all of them together.
    """
    settings, sample_time = search.settings.ranking, held.record.sample_time
    after, squares = errors_ahead(chosen, held), on_held_out(chosen, held).chi2

    def share_of(rest: CandidateFit) -> ClosedShare | None:
        return share_between(before, errors_ahead(rest, held), after, sample_time)

    def spoils(name: str, fit: CandidateFit, share: ClosedShare) -> bool:
        if share.interval[1] >= 0 or surely_worse(fit, chosen, held):
            return False
        off = None if name in shown else share_of(replace(chosen, theta=chosen.switched_off({name})))
        return share.value <= -settings.withdrawn or (off is not None and off.value < NOTHING)

    def gain_nothing(fit: CandidateFit, share: ClosedShare | None) -> bool:
        return share is not None and share.value <= 0 and on_held_out(fit, held).chi2 / squares - 1 <= SAME

    def without(name: str) -> tuple[str, CandidateFit]:
        return name, search.without(chosen, name)

    undetermined = {*unclear(search, chosen, settings.undetermined), *_of_runaway_springs(chosen), *_contained(chosen)}
    shown = search.shown_by_torques(chosen).difference(unclear(search, chosen, CLEAR))
    best, least, needless = None, np.inf, []
    for name, fit in search.parallel("effects on held-out data", without, sorted(chosen.names)):
        share = None if comes_back(name, fit) else share_of(fit)
        if share is None:
            continue
        chance = name in undetermined and gain_nothing(fit, share)
        needless += [name] if chance else []
        if share.value < least and (chance or spoils(name, fit, share)):
            best, least = fit, share.value
    if len(needless) > 1 and len(needless) < len(chosen.names) and not search.deadline.stops():
        rest = search.without(chosen, *needless)
        if not any(comes_back(name, rest) for name in needless) and gain_nothing(rest, share_of(rest)):
            return rest
    return best


def _of_runaway_springs(fit: CandidateFit) -> frozenset[str]:
    """Return the effects of springs whose damping ended at the limit of its search: no log determines either then.

    Args:
        fit: The fit.
    """
    limited = {name.removesuffix(DAMPER) for name in numbers_at_limits(fit) if name.endswith(DAMPER)}
    return frozenset(one.name for one in fit.hypothesis if one.location in limited)


def _contained(fit: CandidateFit) -> frozenset[str]:
    """Return the effects of a fit that another one at their place contains, as presliding friction Coulomb friction.

    Args:
        fit: The fit.
    """
    return fit.names & frozenset[str]().union(*map(simpler, fit.hypothesis))


def comes_back(name: str, fit: CandidateFit) -> bool:
    """Return whether a fit without an effect has it all the same, as a number of the model far out of its tolerance.

    Args:
        name: The effect, effect@location.
        fit: The fit.
    """
    effect, _, location = name.partition("@")
    own = effects()[effect]().numbers(fit.predictor.robot, location)
    return not far_out(fit, STRAINED).keys().isdisjoint(own)
