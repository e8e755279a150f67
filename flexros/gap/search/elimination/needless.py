"""Which effects of an explanation are needless by linear theory, and by how clear torques show their sizes."""

from __future__ import annotations

from dataclasses import replace
from math import hypot
from typing import TYPE_CHECKING

from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.left_out.tool_load import ToolLoad
from flexros.effects.torque_bias import TorqueBias
from flexros.gap.fit.estimates import clearness, parameters_of
from flexros.gap.fit.torques.missing_load import moved_mass
from flexros.gap.fit.torques.unknown_numbers import inertias_of_bodies
from flexros.gap.search.worth import compared, worth

if TYPE_CHECKING:
    from flexros.gap.candidates.candidate import Candidate, FreeParameter
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search

NOTHING = 1e-3
"""Size over the largest one of its search below which an effect is none [1] (chosen): one of size zero seems to be
sharply known."""


def needless_effects(search: Search, fit: CandidateFit, removed: float) -> list[str]:
    """List effects that are not worth their parameters by linear theory, the least missed first.

    While there is time it is one of each motor.

    Effects that torques show are worth it where their size is clearly not zero: at a joint that moves little or carries
    little they remove a small part of the gap of all joints, and are as real as at the others. A size that changes
    nothing, such as a small delay of commands whose servo is at its limit, has no deviation and is not clear.
    Where a further effect at the same motor is not worth it either, that one goes first: beside friction by the load,
    which removes little, Coulomb friction is not clear, and left out first it could not come back. Of the
    effects of a servo the least clear one goes first: at a wrist without weight its inertia, stiffness and viscous
    friction may have any common factor, and without the one that is wrong the others would be clear instead.

    Args:
        search: The search.
        fit: The fit.
        removed: Share of the remaining gap that every effect must remove [1].
    """
    surroundings, n, comparison = search.surroundings(fit), search.data.n_values, compared(search, [fit])
    every, without = surroundings.least, [rest.least for rest in search.removals(fit, surroundings)]
    sizes = parameters_of(fit, search.data) if search.torques_decide else [{} for _ in fit.hypothesis]
    shown = search.shown_by_torques(fit)
    needless: list[tuple[float, Candidate]] = []
    clear_by: dict[str, float] = {}
    for candidate, least, parameters in zip(fit.hypothesis, without, sizes, strict=True):
        cheaper = least * n ** (-len(candidate.free) / n)  # of the same score as with the parameters of the effect
        before, after = replace(fit, chi2=cheaper), replace(fit, chi2=every)
        if candidate.name in shown:
            clear, tolerated = search.settings.search.clear_in_torques, _tolerated(search, candidate)
            nothing = {one.name: _nothing(search, candidate, one) for one in candidate.free}
            if search.data.record.command is not None:
                clear_by[candidate.name] = clearness(parameters.values())
            worth_it = any(
                abs(size.value) > max(clear * hypot(size.std, tolerated), nothing[name])
                for name, size in parameters.items()
                if size.determined and (name == "mass" or candidate.effect is not ToolLoad)
            )
        else:
            worth_it = worth(search, comparison, before, after, removed)
        if least < max(without) and not worth_it:
            needless.append((least, candidate))
    least_first = [one for _, one in sorted(needless, key=lambda pair: pair[0])]
    if all_at_once(search):
        return [one.name for one in least_first]
    ordered = least_first[::-1]  # of those of a location the last one counts
    first = {one.location: one.name for one in sorted(ordered, key=lambda one: -clear_by.get(one.name, 0.0))}
    further = {one.location: one.name for one in ordered if one.name not in shown}
    kept = (first | further).values()
    return [one.name for one in least_first if one.name in kept]


def _tolerated(search: Search, candidate: Candidate) -> float:
    """Return the tolerance of the numbers of the model that a relative error changes [1]; 0 of other effects.

    An error of about the tolerance is none: the number deviates within it.
    """
    if not issubclass(candidate.effect, AbstractRelativeError):
        return 0.0
    changed = candidate.effect().numbers(search.null.model.robot, candidate.location)
    return search.null.fit.predictor.tolerance.largest(changed)


def _nothing(search: Search, candidate: Candidate, free: FreeParameter) -> float:
    """Return the size up to which an effect that torques show is none, however clear it is [unit of its size].

    It is the torque that counts as no gap, of a constant torque at a motor, and the lightest load. The search for
    rotors goes from those of hobby servos to those of large arms, so that the inertia of the bodies tells which are
    none.
    """
    data, robot, least = search.data, search.null.model.robot, NOTHING * free.high
    if candidate.effect is ToolLoad:
        return max(search.settings.torque_start.lightest_load * moved_mass(robot), least)
    if candidate.effect is RotorInertia:
        return NOTHING * inertias_of_bodies(data.record, robot)[candidate.location]
    if candidate.effect is not TorqueBias:
        return least
    tolerated = data.measurement.tolerated_torque(data.record)[robot.joint_names.index(candidate.location)]
    return max(float(tolerated), least)


def all_at_once(search: Search) -> bool:
    """Return whether effects that seem needless are left out together: no torques show them, or no time is left."""
    robot = search.null.model.robot
    return not search.torques_decide or robot.n_coordinates > robot.n_motors or search.deadline.stops()
