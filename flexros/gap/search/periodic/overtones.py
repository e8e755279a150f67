"""Overtones of a torque ripple: a wave that is no pure sine."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.effects.torque_ripple import OVERTONE, TorqueRipple
from flexros.gap.candidates.candidate import free_parameter
from flexros.gap.fit.limits import at_limits
from flexros.gap.search.worth import compared, incomplete

if TYPE_CHECKING:
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search

LOWERED = 0.05
"""Share by which an overtone lowers the sum of squares of a measured log [1] (chosen)."""


def with_overtones(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Let the torque ripples of an explanation have an overtone, where what is left shows one.

    A large ripple whose wave is no pure sine leaves a small part of itself, in which all smaller effects drown: each of
    them removes little of it. No other candidate can have that part, as an effect is in an explanation once at a motor.
    In a measured log it must lower all that is left, noise included: a cogging of a series elastic actuator had one of
    a third of its amplitude, for which a transmission error and a delay stood.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; a new one is appended.

    Returns:
        The explanation with overtones under the same names, or the same fit.
    """
    wide = tuple(_with_overtone(one) if _is_pure(one) else one for one in fit.hypothesis)
    if wide == fit.hypothesis or search.deadline.stops():
        return fit
    if not incomplete(search, compared(search, [fit]), fit):
        return fit
    wavy = search.reshaped(fit, wide)
    comparison = compared(search, [fit, wavy])
    gains = comparison.score(wavy) - comparison.score(fit) > comparison.threshold
    if not search.premises.floor_is_noise:
        gains = gains and wavy.chi2 < (1 - LOWERED) * fit.chi2
    if not gains or any(name in OVERTONE for _, name in at_limits(wavy)):
        return fit
    fits.append(wavy)
    return wavy


def _is_pure(candidate: Candidate) -> bool:
    """Return whether a candidate is a ripple of a free order without an overtone."""
    names = {free.name for free in candidate.free}
    return candidate.effect is TorqueRipple and "order" in names and not names & {*OVERTONE}


def _with_overtone(candidate: Candidate) -> Candidate:
    """Free the overtone of a ripple, with as many initial values as its other parameters have."""
    further = [free_parameter(name, TorqueRipple.ranges[name], 1.0) for name in OVERTONE]
    same = [replace(one, starts=one.starts[:1] * len(candidate.free[0].starts)) for one in further]
    return replace(candidate, free=(*candidate.free, *same))
