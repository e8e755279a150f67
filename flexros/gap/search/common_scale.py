"""Common scale: a gain of a torque, or an inertia and all other sizes in proportion, in logs of torques."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.torque_bias import TorqueBias
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.gap.candidates.one_scale import of_one_scale
from flexros.gap.search.fits.additions import Addition
from flexros.gap.search.proportion import in_proportion, other_scales

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search


@dataclass(frozen=True, eq=False)
class _Exchange:
    """An effect of an explanation for a candidate.

    Attributes:
        begun: Where the fit begins.
        gone: The effect that goes.
        new: The candidate that takes its place.
        size: Its size at first [1].
    """

    begun: CandidateFit
    gone: str
    new: Candidate
    size: float


def with_common_scale(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Try an inertia in place of the gain of a torque, in a measured log of torques, and a gain for a constant torque.

    A torque that is too large by a factor moves an arm as one that is right moves more inertia against more friction
    and stiffer springs. Linear theory does not see that: all sizes differ by the factor. A constant torque may stand
    for a gain, which scales the weight that a motor carries. An inertia that was found beside friction gives no way to
    a gain: a drive is calibrated, and what it carries is not. Rotors that the robot file leaves out and numbers of the
    model take their part of the scale by themselves. Errors of gains may be one of the scale of the whole arm, see
    `other_scales`.

    Args:
        search: The search.
        chosen: The explanation, at its end.
        fits: All fits so far; new ones are appended.

    Returns:
        The explanation as it was: the others are its rivals, between which the held-out log decides as well.
    """
    if search.premises.library_is_complete or search.data.record.command is not None:
        return chosen
    if not search.deadline.stops():
        fits += search.parallel("common scale", partial(_fitted, search), list(_exchanges(search, chosen)))
    if not search.deadline.stops():
        fits += search.parallel("common scale", search.completed, list(other_scales(search, chosen)))
    return chosen


def _exchanges(search: Search, fit: CandidateFit) -> Iterator[_Exchange]:
    """Yield an inertia for every gain, and a gain for every constant torque at a motor."""
    candidates = [one for one in search.candidates() if one.name not in fit.names]
    sizes = {one.name: own for one, own in zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True)}
    for one in fit.hypothesis:
        if one.effect is TorqueGainError:
            factor = 1 + sizes[one.name]["relative"]
            begun = in_proportion(fit, one)
            for new in candidates:
                if of_one_scale(one, new):
                    yield _Exchange(begun, one.name, new, 1 / factor - 1)
        elif one.effect is TorqueBias:
            for new in candidates:
                if new.effect is TorqueGainError and new.location == one.location:
                    yield _Exchange(fit, one.name, new, 0.0)


def _fitted(search: Search, exchange: _Exchange) -> CandidateFit:
    """Fit an explanation with an exchange, to the end."""
    (free,) = exchange.new.free
    nothing = np.zeros(len(exchange.begun.predictor.tolerance.names), dtype=bool)
    start = np.clip(np.array([free.encode(exchange.size)]), *free.bounds)
    addition = Addition(exchange.new, 0.0, start, nothing, np.zeros(len(search.rows), dtype=np.float32))
    return search.completed(search.together(exchange.begun, [addition], without=(exchange.gone,)))
