"""Laws of a measured log that become richer ones which contain them, and rich ones or curves that simpler replace."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.gear.nonlinear_stiffness import NonlinearStiffness
from flexros.effects.gear.stiffness_error import StiffnessError
from flexros.effects.kinds.curve import AbstractCurve
from flexros.gap.candidates.candidate import simpler
from flexros.gap.search.exchange import RICH
from flexros.gap.search.regrouping import in_proportion
from flexros.gap.search.worth import compared, worth

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search

PROMISES = 0.02
"""Least fall of the sum of squares at the best of some initial values, over the sum, from which a richer law is fitted
[1] (chosen)."""


def best_richer(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit | None:
    """Fit an explanation with one of its laws in a richer form that contains it, begun with what is known of it.

    Simple laws at all joints come first on a real machine, and a rich one that does little more than a simple one does
    alone is not looked at. Of the whole gap that is little; of what an explanation leaves it may be most: Coulomb
    friction does most of what friction which bends before it slides does.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; new ones are appended.

    Returns:
        The best of the new fits; None for a simulated log, whose search looks at all laws, and where no further
        parameter makes an explanation clearly better at once.
    """
    if search.premises.library_is_complete or search.deadline.stops():
        return None
    pairs = [
        (one, rich)
        for rich in search.candidates()
        for one in fit.hypothesis
        if one.name in simpler(rich) and rich.name not in fit.names
    ]
    least = max(compared(search, [fit]).threshold, PROMISES * fit.chi2)
    plants = search.plants(fit, [rich for _, rich in pairs])
    begun = search.parallel("richer effects", lambda pair: search.enriched(fit, *pair, plants[pair[1]], least), pairs)
    found = search.visible([search.completed(one) for one in begun if one is not None])
    fits += found
    return min(found, key=lambda one: one.chi2, default=None)


def with_richer_laws(
    search: Search, fit: CandidateFit, fits: list[CandidateFit]
) -> tuple[CandidateFit, CandidateFit | None]:
    """Take richer laws in place of those of an explanation for as long as one is worth it; arguments as before.

    Returns:
        The explanation, and the best one with a further richer law, which is not worth it; None without one.
    """
    removed = search.settings.search.removed_of_all
    while (richer := best_richer(search, fit, fits)) is not None:
        if not worth(search, compared(search, [fit, richer]), fit, richer, removed):
            break
        fit = richer
    return fit, richer


def with_simpler_effects(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Take a wrong number of the model in place of a rich law that leaves no less than it, and a law for a curve.

    An exchange is tried where linear theory sees what is lost without a law, which is far too much for a large one that
    tolerated numbers stand for in part: hysteresis of a gear that bends by much more than the gear does is a spring
    that is too stiff. So an explanation is fitted without each rich law, and candidates are screened beside that. A law
    of few parameters may have been out of reach while others were missing: a curve bends to it in one step, as to the
    backlash of a gear beside an unknown load.

    Args:
        search: The search.
        fit: The explanation of a measured log.
        fits: All fits so far; new ones are appended.
    """
    if search.premises.library_is_complete:
        return fit
    settings, fit = search.settings.search, _without_knees(search, fit, fits)
    rich = [one for one in fit.hypothesis if len(one.free) >= RICH and one.name not in search.of_torques]
    if not rich:
        return fit
    numbers = [one for one in search.candidates() if in_proportion(one)]
    for law in sorted(rich, key=lambda one: issubclass(one.effect, AbstractCurve)):  # beside wrong laws none fits
        if search.deadline.stops():
            break
        rest = search.completed(search.without(fit, law.name))
        additions = search.additions(search.directions(numbers, rest), rest, search.surroundings(rest))
        promising = [one for one in additions if one.gain > settings.regained * (rest.chi2 - fit.chi2)]
        promising = promising[: settings.added]
        found = search.parallel("simpler effects", partial(search.together, rest), [[one] for one in promising])
        found += _in_place(search, [fit], law, [one.candidate for one in promising])
        lawful = _laws_in_place(search, fit, law)
        found += lawful
        if not found:
            continue
        best = search.beside_jumps(search.completed(min(found, key=lambda one: one.chi2)))
        if best.chi2 > fit.chi2 and lawful:  # a curve takes up a part of what else is missing
            best = search.completed(min(lawful, key=lambda one: one.chi2))
        comparison = compared(search, [best, fit])
        fewer = best.predictor.n_effect < fit.predictor.n_effect
        as_good = best.chi2 <= fit.chi2 or (fewer and comparison.score(best) > comparison.score(fit))
        if as_good or (lawful and not worth(search, comparison, best, fit, settings.removed_of_all)):
            fits += [rest, *found, best]
            fit = best
    return fit


def _without_knees(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Take a wrong stiffness in place of a spring with a knee that is hardly better, in a measured log.

    Beside backlash a knee at a small deflection stands for a part of the gap, which is too small then: so the search
    may find it first, and without it nothing near is left.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; new ones are appended.
    """
    stiffness = {one.location: one for one in search.candidates() if one.effect is StiffnessError}
    for knee in [one for one in fit.hypothesis if one.effect is NonlinearStiffness and one.location in stiffness]:
        plain = stiffness[knee.location]
        if search.deadline.stops() or plain in fit.hypothesis:
            continue
        plant = search.plants(fit, [plain])[plain]
        begun = search.in_place(fit, knee, plain, plant, np.inf, refined=True)
        if begun is None:
            continue
        fits.append(search.completed(begun))
        comparison = compared(search, [fits[-1], fit])
        if not worth(search, comparison, fits[-1], fit, search.settings.search.removed_of_all):
            fit = fits[-1]
    return fit


def _laws_in_place(search: Search, fit: CandidateFit, curve: Candidate) -> list[CandidateFit]:
    """Fit laws with fewer parameters at the motor or gear of a curve in its place, begun with all else as it is.

    A wrong number of the gear beside the curve may stand for a part of the law, so that it is also tried without that.

    Args:
        search: The search.
        fit: The explanation with the curve.
        curve: The curve; none of its kind, and no law is fitted.
    """
    if not issubclass(curve.effect, AbstractCurve):
        return []
    places = [{motor.name, motor.joint.name} for motor in search.null.model.robot.motors]
    own = next((place for place in places if curve.location in place), {curve.location})
    every = [one for one in search.candidates(for_curve=True) if one.location in own and one.name not in fit.names]
    laws = [one for one in every if not in_proportion(one) and len(one.free) < len(curve.free)]
    numbers = [one.name for one in fit.hypothesis if one.location == curve.location and in_proportion(one)]
    return _in_place(search, [fit, *([search.without(fit, *numbers)] if numbers else [])], curve, laws)


def _in_place(
    search: Search, fits: Sequence[CandidateFit], law: Candidate, others: Sequence[Candidate]
) -> list[CandidateFit]:
    """Fit explanations with each of some candidates in place of a law, begun with all else as it is.

    Without the law, other sizes would go far to make up for it: backlash became so wide that a softer spring, which an
    added mode had stood for, did not bring it back.
    """
    plants = search.plants(fits[0], others)

    def in_place(pair: tuple[CandidateFit, Candidate]) -> CandidateFit | None:
        fit, other = pair
        return search.in_place(fit, law, other, plants[other], np.inf, refined=True)

    pairs = [(fit, other) for fit in fits for other in others]
    return [one for one in search.parallel("effects in place", in_place, pairs) if one is not None]
