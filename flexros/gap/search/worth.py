"""What effects must achieve to be added to an explanation, and to stay in it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.base_tilt import BaseTilt
from flexros.effects.kinds.curve import AbstractCurve
from flexros.effects.kinds.law import AbstractLaw
from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.effects.torque_bias import TorqueBias
from flexros.gap.candidates.candidate import is_uneven, simpler
from flexros.gap.fit.tolerance_takeover import takeover
from flexros.gap.fit.torques.solution import is_silent
from flexros.gap.fit.uncertainty.constancy import constancies
from flexros.gap.search.model_probability import ModelComparison, compare

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.additions import Addition
    from flexros.gap.search.fits.candidate_fits import Search

FAR = 4.0
"""Deviation of a number of the model over its tolerance from which its error is named [1] (chosen): of some forty
numbers of an arm one is beyond three now and then."""


def compared(search: Search, fits: Sequence[CandidateFit]) -> ModelComparison:
    """Compare fits with each other and with the nominal model."""
    return compare(search.data, search.null.fit, fits, search.distance, search.chance, search.settings.ranking)


def incomplete(search: Search, comparison: ModelComparison, chosen: CandidateFit) -> bool:
    """Return whether an explanation leaves more than noise or moves parameters beyond tolerance.

    The floor of a real machine is a tolerance: above it something is left, and below it there may be what is worth it.
    So it is where positions are rounded so coarsely that the level without gap is known worse than by chance: what
    effects must gain there, `threshold`, allows for the rounding.
    """
    if (comparison.rounding > 0 and floor_is_uncertain(comparison)) or not search.premises.floor_is_noise:
        return True
    return more_than_chance(comparison, chosen) or comparison.beyond_tolerance(chosen)


def floor_is_uncertain(comparison: ModelComparison) -> bool:
    """Return whether the level without gap is known worse than by chance.

    So it is of noise that is coloured, measured or made by coarse rounding. No level near it tells noise from an effect
    there, but what an effect gains does: the colour of an encoder left a doubt of 3 %, in which friction of 3000 nats
    was not looked for.
    """
    return comparison.floor_error > _chance(comparison)


def more_than_chance(comparison: ModelComparison, fit: CandidateFit) -> bool:
    """Return whether a fit leaves more than noise of the stated level would by chance."""
    return comparison.level(fit) - 1.0 > comparison.settings.significant * _chance(comparison)


def more_than_before(search: Search, comparison: ModelComparison, fit: CandidateFit) -> bool:
    """Return whether a fit leaves more than noise left by chance in the same log tied more closely.

    How large coloured or measured noise is, an explanation that left noise has shown: beside a doubt of 12 % errors of
    form, of a fifth of the noise, were imitated.
    """
    if search.left_before is None:
        return False
    by_chance = 2**0.5 * _chance(comparison)  # of both levels
    return comparison.level(fit) - search.left_before > comparison.settings.significant * by_chance


def in_vain(search: Search, fit: CandidateFit) -> bool:
    """Return whether an explanation leaves more than noise where a search is resumed in a looser tie.

    It counts for nothing there if it ends so. Where no candidate adds to the explanation, none does better in place of
    one of its effects; and what laws leave after exchanges, curves would take up, which are none.
    """
    if not search.resumed:
        return False
    comparison = compared(search, [fit])
    return comparison.significant(fit) or more_than_before(search, comparison, fit)


def _chance(comparison: ModelComparison) -> float:
    """Return the standard deviation of the level without gap, of noise that is known [1]."""
    return float(np.sqrt(2.0 / comparison.n_values))


def worth(
    search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit, removed: float
) -> bool:
    """Return whether further effects remove a good part of the remaining gap, or of the prior penalty.

    They do where the prediction without them diverges.
    """
    if not np.isfinite(before.chi2):
        return bool(np.isfinite(after.chi2))
    if _gained(search, comparison, before, after) < comparison.threshold:
        return False
    if not _beyond_form(search, comparison, before, after, search.settings.search.least_of_gap):
        return False
    if not search.premises.floor_is_noise:
        if strains(search, comparison, after, before) or turned_in_torques(search, before, after):
            return True
        removed = search.settings.search.removed_of_all
        if comparison.level(before) <= search.settings.ranking.floors:
            if _completes(comparison, before, after) or _beyond_tolerance_of_a_motor(search, comparison, before, after):
                return True
            return _within_floor(search, comparison, before, after)
    relieved = after.prior_penalty < (1 - removed) * before.prior_penalty
    if comparison.beyond_tolerance(before) and relieved and search.premises.floor_is_noise:
        return True
    if search.premises.floor_is_noise and _down_to_noise(search, comparison, before, after):
        return True
    if search.premises.floor_is_noise and _constant_beside_uneven(before, after):
        return True
    within_noise = search.premises.floor_is_noise and not more_than_chance(comparison, before)
    return (
        (comparison.removed(before, after) >= removed and not within_noise)
        or _at_one_motor(search, comparison, before, after)
        or _constant(search, comparison, before, after)
    )


def _beyond_form(
    search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit, share: float
) -> bool:
    """Return whether further effects remove more than the form of all laws of an explanation may miss.

    Args:
        search: The search.
        comparison: A comparison of fits of the log.
        before: The explanation without the effects.
        after: The explanation with them.
        share: Model-form error as a share of the gap that laws make [1].
    """
    removed = comparison.level(before) - comparison.level(after)
    if removed >= share * (comparison.level(comparison.null) - 1.0):
        return True
    return removed >= share * gap_of_laws(search, comparison, after)


def gap_of_laws(search: Search, comparison: ModelComparison, fit: CandidateFit) -> float:
    """Return the gap beyond noise that is left when all laws of an explanation are switched off [1].

    It is the gap that their form matters for. A wrong number of the model has its form from the model: however large
    the gap is that it makes, once it is corrected it hides no effect in a simulated log. A load that was half of the
    true one made a gap of 2e6, beside which five effects of 300 to 8000 nats seemed to be errors of form.

    Args:
        search: The search.
        comparison: A comparison of fits of the log.
        fit: The explanation.
    """
    whole = comparison.level(comparison.null) - 1.0
    laws = {one.name for one in fit.hypothesis if not _number(one)}
    if not search.premises.library_is_complete or len(laws) == len(fit.hypothesis):
        return whole
    return min(search.level_without(fit, laws) - 1.0, whole)


def _number(candidate: Candidate) -> bool:
    """Return whether a candidate is a number of the model, without a law of its own."""
    return issubclass(candidate.effect, AbstractChangedValues) and not issubclass(candidate.effect, AbstractLaw)


def _down_to_noise(search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether further effects leave no more than noise, and gain more than the form of all laws may miss.

    What remains is known to within chance only, which may be most of it: the share that an effect removes says nothing
    there, and less where no more than noise remains without it: two axes went on to gain 300 nats at a time, of a gap
    of 2000 floors. What it gains does, beyond the model-form error of the whole gap.
    """
    if more_than_chance(comparison, after):
        return False
    return _beyond_form(search, comparison, before, after, comparison.settings.shaped_form)


def _constant_beside_uneven(before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether all that an explanation has beyond another one is a constant torque beside uneven friction.

    The asymmetry takes up most of such a torque: what the torque removes beside it says nothing, but it gains more
    than by chance.
    """
    further = [one for one in after.hypothesis if one.name not in before.names]
    uneven = {one.location for one in before.hypothesis if is_uneven(one)}
    return bool(further) and all(one.effect is TorqueBias and one.location in uneven for one in further)


def _completes(comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether further effects take what is left of a small gap, too much for an explanation, below the floor."""
    beyond = comparison.level(comparison.null) > comparison.settings.floors
    return beyond and not comparison.adequate(before) and comparison.level(after) <= 1.0


def _beyond_tolerance_of_a_motor(
    search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit
) -> bool:
    """Return whether further effects remove more than the tolerance of a motor's torque, which does not excuse them.

    What an explanation may leave is two floors of all motors together. An effect at one of them may be larger than the
    tolerance of its torque: a ripple of a sixth of the rms torque of one of six motors was a third of what was left
    above the floor, and ripples at two of them were within it beside four motors that left little. So many floors of
    single motors are removed as the mean over all of them falls, times their number, of a good part of what is above
    the floor. So it is of what is above the floor of one motor; an estimate by linear theory says nothing of single
    motors, and a fit decides.
    """
    removed = search.settings.search.removed_of_all
    motors = search.data.record.position.shape[1]
    of_motors = motors * (comparison.level(before) - comparison.level(after))
    if not of_motors > 1.0:
        return False
    if comparison.level(before) > 1.0 and comparison.removed(before, after) >= removed:
        return True
    if before.names == after.names:
        return True
    first, second = (_levels_of_motors(search, fit) for fit in (before, after))
    return bool(np.any(first - second > np.maximum(1.0, removed * (first - 1.0))))


def _levels_of_motors(search: Search, fit: CandidateFit) -> FloatArray:
    """Return the mean squared prediction errors of each motor over its floor [1], shape (n_motors,)."""
    n, M = search.data.record.position.shape
    squares: FloatArray = np.sum(fit.residual(search.data)[: M * n].reshape(M, n) ** 2, axis=1)
    return squares / search.data.values_of_motors


def _within_floor(search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether further effects take most of what there is beyond noise, as they do where torques are known well.

    An effect that is far smaller than the tolerance of the torques is within it. Beside a curve, which is no law, what
    is left beyond noise is the form that it lacks, and others would imitate that: then most of all must be taken.
    """
    numbers = search.settings.search
    if any(issubclass(one.effect, AbstractCurve) for one in before.hypothesis):
        return comparison.level(after) < numbers.within_floor * comparison.level(before)
    for noise in comparison.levels_of_noise:
        first, second = (comparison.beyond_noise(comparison.level(fit), noise) for fit in (before, after))
        if second < numbers.within_floor * first and first - second > numbers.least_of_tolerance**2:
            return True
    return False


def _constant(search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether further effects of constant size remove a part of what a cause outside the library may leave.

    Where an explanation suffices, what its effects leave is a model-form error, which candidates imitate constantly
    too. Both must be fits: an estimate by linear theory has no sizes.
    """
    if not search.premises.library_is_complete or comparison.adequate(after):
        return False
    further = after.names - before.names
    if not further or comparison.removed(before, after) < search.settings.search.removed_if_constant:
        return False
    found = constancies(after, search.data, search.settings.ranking)
    return all(found[name] >= search.settings.ranking.constant for name in further)


def _at_one_motor(search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether further effects remove most of what remains at one of several motors, in a simulated log.

    What no effect explains at one motor may be far more than all the rest: beside it, effects at the others remove
    little of the whole. Both must be fits: an estimate by linear theory says nothing of single motors.
    """
    one_motor = search.data.record.position.shape[1] == 1
    if not search.premises.library_is_complete or one_motor or before.names == after.names:
        return False
    first, second = (np.maximum(_levels_of_motors(search, fit), 1e-300) for fit in (before, after))
    removed = (first - second) / np.maximum(first - 1.0, 1e-12)
    cost = comparison.penalty(after) - comparison.penalty(before)
    gained = search.data.values_of_motors * np.log(first / second) - cost
    return bool(np.any((removed > search.settings.search.removed_at_motor) & (gained > comparison.threshold)))


def _gained(search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> float:
    """Return the gain less penalty of an explanation over another one [1].

    The floor of a real machine is a tolerance: where torques are known far better, as in the log of a simulator, the
    levels of right explanations are far below it, and differences between them are no accident of little noise.
    """
    if search.premises.floor_is_noise or comparison.level(before) > 1.0:
        return comparison.score(after) - comparison.score(before)
    ratio = comparison.level(before) / max(comparison.level(after), 1e-300)
    return comparison.n_values * float(np.log(ratio)) - comparison.penalty(after) + comparison.penalty(before)


def strains(search: Search, comparison: ModelComparison, fit: CandidateFit, rest: CandidateFit) -> bool:
    """Return whether an explanation without some effects pulls numbers of the model far out of tolerance for them.

    Either all numbers together, or, in a good explanation, the one that an effect is the error of: beside many numbers
    within tolerance, one that is five tolerances off is hardly a strain of all.

    Args:
        search: The search.
        comparison: A comparison of fits of the log.
        fit: The explanation with the effects.
        rest: The explanation without them, fitted.
    """
    freed = rest.prior_penalty - fit.prior_penalty
    if freed > search.settings.search.freed * rest.prior_penalty and comparison.beyond_tolerance(rest):
        return True
    if not freed > FAR**2 / 2 or comparison.level(rest) > search.settings.ranking.floors:
        return False
    kept = {one.name for one in rest.hypothesis}
    return any(_takes_over_a_far_number(one, rest) for one in fit.hypothesis if one.name not in kept)


def turned_in_torques(search: Search, before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether a slant of the base is all that an explanation has beyond another one, and torques show it.

    Encoder offsets, rotors and lengths take up a part of it each, so that it removes little of what is left.
    """
    further = [one for one in after.hypothesis if one.name not in before.names]
    if search.data.torques is None or [one.effect for one in further] != [BaseTilt]:
        return False
    settings = search.settings.torque_start
    return lowered_torques(search, before, after) >= settings.turned ** len(further[0].free)


def lowered_torques(search: Search, before: CandidateFit, after: CandidateFit) -> float:
    """Return the factor by which a fit leaves less of the torques than another one, over all motors [1].

    It is that of a regression, see `flexros.gap.fit.torques.missing_load.lowered`, with all effects in place.

    Args:
        search: The search, in a log whose torques count.
        before: One fit.
        after: The other one.
    """
    assert search.data.torques is not None
    M = search.null.model.robot.n_motors
    left = [
        np.linalg.norm(fit.residual(search.data)[-search.data.torques.size :].reshape(M, -1), axis=1)
        for fit in (before, after)
    ]
    counts = ~is_silent(left[0])
    factors = left[0][counts] / np.maximum(left[1][counts], 1e-300)
    return float(np.prod(np.minimum(factors, search.settings.torque_start.explained_by_load)))


def _takes_over_a_far_number(candidate: Candidate, rest: CandidateFit) -> bool:
    """Return whether an effect is the error of a number that a fit without it moves far out of its tolerance."""
    if not issubclass(candidate.effect, AbstractRelativeError):
        return False
    found = takeover(candidate, rest)
    return found is not None and found.gain > FAR**2


def simple_first(search: Search, fit: CandidateFit, additions: Sequence[Addition]) -> list[Addition]:
    """Leave out rich effects of which a simpler one does nearly as much, or that a fit has already.

    On a real machine many effects are left to be found, and the simple ones at all joints come first; a rich one may
    take the place of a simple one in the end.
    """
    if search.premises.library_is_complete:
        return list(additions)
    gains = {addition.candidate.name: addition.gain for addition in additions}
    simple = search.settings.search.simple

    def needed(addition: Addition) -> bool:
        names = simpler(addition.candidate)
        return not names & fit.names and all(gains.get(name, 0.0) < simple * addition.gain for name in names)

    return [addition for addition in additions if needed(addition)]


def simplest(
    search: Search, comparison: ModelComparison, fit: CandidateFit, fits: Sequence[CandidateFit]
) -> CandidateFit:
    """Return a fit with a simpler effect in place of a rich one that hardly does more, on a real machine."""
    if search.premises.library_is_complete:
        return fit
    for candidate in fit.hypothesis:
        rest = fit.names - {candidate.name}
        plainer = [other for other in fits if any(other.names == rest | {name} for name in simpler(candidate))]
        for other in plainer:
            if not worth(search, comparison, other, fit, search.settings.search.removed_by_step):
                return other
    return fit


def beyond_noise(search: Search, fit: CandidateFit) -> float:
    """Return what a fit leaves beyond the noise of sensors, over what the tolerance of torques adds to it [1].

    Args:
        search: The search.
        fit: The fit.
    """
    comparison = compared(search, [fit])
    return comparison.beyond_noise(comparison.level(fit))
