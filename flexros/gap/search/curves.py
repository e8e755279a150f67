"""Torques of unknown law: curves over speed, position, time and deflection for what no law of the library explains."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.kinds.curve import AbstractCurve
from flexros.effects.torque_bias import TorqueBias
from flexros.gap.candidates.candidate import simpler
from flexros.gap.search.curve_candidates import list_curves, within_motion, without_shared
from flexros.gap.search.fits.additions import Addition
from flexros.gap.search.worth import compared, worth

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from flexros.gap.candidates.candidate import Candidate, Hypothesis
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.directions import Directions
    from flexros.gap.fit.screening import Surroundings
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.model_probability import ModelComparison


def with_curves(
    search: Search,
    fit: CandidateFit,
    directions: Sequence[Directions],
    fits: list[CandidateFit],
    wanted: Collection[str] = (),
) -> CandidateFit:
    """Add curves to an explanation of a real machine, where they explain clearly more than any further law.

    All sizes of a curve are free together, and those of all laws with them: a model-form error of one law, or friction
    of a law that is not in the library, then moves no others. On a simulated robot every law is in the library.

    Args:
        search: The search.
        fit: The explanation by laws.
        directions: All candidates but those of harmonics.
        fits: All fits so far; a new one is appended.
        wanted: Names of the curves that compete, effect@location, whatever laws would explain; default: all that
            explain clearly more.

    Returns:
        The explanation with curves, or the same fit.
    """
    if search.premises.library_is_complete or search.deadline.stops():
        return fit
    surroundings = search.surroundings(fit)
    listed = [one for one in list_curves(search, fit) if not wanted or one.name in wanted]
    curves = [one for one in search.directions(listed, fit) if one.usable.all()]
    if not wanted:
        curves = _beyond_laws(search, surroundings, curves, search.additions(directions, fit, surroundings))
    group = _selected(search, fit, surroundings, curves)
    while group and not search.deadline.stops():
        changes = [one.changes for one in group]
        sizes = np.split(surroundings.sizes(np.hstack(changes)), np.cumsum([one.shape[1] for one in changes])[:-1])
        nothing = np.zeros(len(fit.predictor.tolerance.names), dtype=bool)
        additions = [
            Addition(one.candidate, 0.0, one.starts @ size, nothing, one.changes @ size.astype(np.float32))
            for one, size in zip(group, sizes, strict=True)
        ]
        grown = search.together(fit, additions)
        if _worth(search, compared(search, [fit]), fit, grown):
            fits.append(search.completed(within_motion(search, grown)))
            return fits[-1]
        group = group[:-1]
    return fit


def curves_of(hypothesis: Hypothesis) -> list[Candidate]:
    """List the curves among the candidates of a hypothesis."""
    return [one for one in hypothesis if issubclass(one.effect, AbstractCurve)]


def with_constants(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Let curves of torques take up the constant torque at their motor, which is a part of them.

    Beside the constant one, a curve lacks its first size. Both together are one cause.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; new ones are appended.
    """
    for curve in curves_of(fit.hypothesis):
        sizes = {one.name: one for one in curve.free}
        shared = curve.effect.extends.get(TorqueBias.name, {})
        lacking = [replace(curve.free[0], name=name) for name in shared if name not in sizes]
        constant = next((one for one in fit.hypothesis if one.name == f"{TorqueBias.name}@{curve.location}"), None)
        if not lacking or constant is None or search.deadline.stops():
            continue
        whole = replace(curve, free=(*lacking, *curve.free))
        values = dict(zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True))
        level = values[constant]["level"]
        values[whole] = {one.name: level + values[curve].get(one.name, 0.0) for one in whole.free}
        hypothesis = tuple(whole if one is curve else one for one in fit.hypothesis if one is not constant)
        begin = [free.encode(values[one][free.name]) for one in hypothesis for free in one.free]
        predictor = search.null.predictor(hypothesis, fit.predictor.plant)
        fit = search.completed(replace(fit, predictor=predictor, theta=np.concatenate([begin, fit.deviations])))
        fits.append(fit)
    return fit


def in_place_of_laws(search: Search, fit: CandidateFit, curved: CandidateFit) -> CandidateFit:
    """Fit an explanation without the laws at the motors of curves, but those that the curves contain.

    Args:
        search: The search.
        fit: The explanation.
        curved: Another one with curves.
    """
    curves = curves_of(curved.hypothesis)
    places = {one.location for one in curves}
    kept = frozenset[str]().union(*(simpler(one) for one in curves))
    names = [one.name for one in fit.hypothesis if one.location in places and one.name not in kept]
    return search.without(fit, *names) if names else fit


def _beyond_laws(
    search: Search, surroundings: Surroundings, curves: Sequence[Directions], laws: Sequence[Addition]
) -> list[Directions]:
    """List the curves that explain clearly more than any single law at their motor or gear, or at none, would."""
    robot, margin = search.null.model.robot, search.settings.search.beyond_laws
    found = []
    for curve in curves:
        place = curve.candidate.location
        others = {motor.name for motor in robot.motors if place not in (motor.name, motor.joint.name)}
        rivals = [law.gain for law in laws if law.candidate.location not in others]
        gain = surroundings.least - surroundings.left(curve.changes)
        if gain > margin * max(rivals, default=0.0):
            found.append(curve)
    return found


def _selected(
    search: Search, fit: CandidateFit, surroundings: Surroundings, curves: Sequence[Directions]
) -> list[Directions]:
    """Select curves one after the other, for as long as one is worth its sizes by linear theory."""
    n, comparison, settings = search.data.n_values, compared(search, [fit]), search.settings.search
    group: list[Directions] = []
    least = surroundings.least
    while len(group) < min(len(curves), settings.curves):
        chosen = [one.candidate.name for one in group]
        rest = [without_shared(one, group) for one in curves if one.candidate.name not in chosen]
        lefts = [surroundings.left(np.hstack([*(other.changes for other in group), one.changes])) for one in rest]
        best, left = rest[int(np.argmin(lefts))], min(lefts)
        charged = left * n ** (len(best.candidate.free) / n)  # of the same score as without its sizes
        before, after = replace(fit, chi2=least), replace(fit, chi2=charged)
        if not _worth(search, comparison, before, after):
            break
        group.append(best)
        least = left
    return group


def _worth(search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether curves remove a good part of all that is left, counted down to the floor.

    The floor of a real machine is a stated tolerance, errors of the model included. A curve bends to these as well, and
    what it makes of them does not hold in other motions.
    """
    removed = search.settings.search.removed_of_all
    above = comparison.level(before) - max(comparison.level(after), 1.0)
    return above >= removed * comparison.level(before) and worth(search, comparison, before, after, removed)
