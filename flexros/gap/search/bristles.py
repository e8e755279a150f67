"""Bristles of dry friction: contacts that yield by less than an encoder shows."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.effects.friction.presliding_friction import SEEN
from flexros.effects.kinds.yielding_friction import BRISTLES, AbstractYieldingFriction
from flexros.gap.candidates.candidate import FreeParameter
from flexros.gap.fit.limits import at_limits
from flexros.gap.search.worth import compared

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search


def with_bristles(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Let the dry friction of an explanation hold by bristles, where a log shows them.

    Contacts that bend by less than the encoder shows shift the instants of reversals. Held rigidly, they leave a rest
    there, which biases the sizes of all other effects and hides small ones; a lag may explain it better than the delay
    that is there. An explanation may leave no more than noise because an inertia took up that rest: so bristles are
    tried there too, and what is needless beside them goes later. Bristles that only stood for an effect which the
    explanation has by now go again. What bends by more is presliding friction, which competes on its own. On a real
    machine the floor is a tolerance, and curves take up what laws leave.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; new ones are appended.

    Returns:
        The explanation with bristles, or without those it had, under the same names, or the same fit.
    """
    firm = _without_bristles(search, fit)
    if firm is not fit:
        fits[:] = [*(one for one in fits if one.names != fit.names), firm]
        return firm
    if not search.premises.library_is_complete:
        return fit
    left = {one.effect for one in _rigid(search, fit)}
    while left and not search.deadline.stops():
        rigid = _rigid(search, fit)
        found = {}
        for law in sorted(left, key=lambda law: law.name):
            levels = {one.name: size for one, size in rigid.items() if one.effect is law}
            held = _held_by(search, fit, levels) if levels else None
            if held is not None:
                found[law] = held
        if not found:
            break
        best = min(found, key=lambda law: found[law].chi2)
        fit = found[best]
        fits.append(fit)
        left.discard(best)
    return fit


def _rigid(search: Search, fit: CandidateFit) -> dict[Candidate, float]:
    """Return the rigid dry frictions of a fit that may hold by bristles, with their levels [Nm or N]."""
    return {
        one: values[one.effect.size]
        for one, values in zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True)
        if issubclass(one.effect, AbstractYieldingFriction)
        and not {free.name for free in one.free} & BRISTLES.keys()
        and not any(free.signed for free in one.free)  # one that takes friction away has no bristles
        and _noise(search, one) > 0
    }


def _held_by(search: Search, fit: CandidateFit, levels: Mapping[str, float]) -> CandidateFit | None:
    """Let frictions of one law hold by bristles; None where that gains less than it costs.

    One law at a time: begun with those of both at once, or of the one that yields less, a fit ended at 1.18 times the
    noise, begun with the other one at 1.15.

    Args:
        search: The search.
        fit: The explanation.
        levels: Levels of the frictions [Nm or N], by effect@location.
    """
    held = [_held(search, one, levels[one.name]) if one.name in levels else one for one in fit.hypothesis]
    bent = search.reshaped(fit, tuple(held))
    if unbent := _at_limits(bent, levels):
        pairs = zip(fit.hypothesis, held, strict=True)
        bent = search.reshaped(fit, tuple(one if one.name in unbent else other for one, other in pairs))
    comparison = compared(search, [fit, bent])
    gains = comparison.score(bent) - comparison.score(fit) > comparison.threshold
    return bent if gains and not _at_limits(bent, levels.keys() - unbent) else None


def _without_bristles(search: Search, fit: CandidateFit) -> CandidateFit:
    """Hold the friction of an explanation rigidly where its bristles are not worth their parameters."""
    rigid = tuple(
        one.without_unsaid() if issubclass(one.effect, AbstractYieldingFriction) else one for one in fit.hypothesis
    )
    if rigid == fit.hypothesis or search.deadline.stops_finishing():
        return fit
    firm = search.reshaped(fit, rigid)
    comparison = compared(search, [fit, firm])
    return firm if comparison.score(fit) - comparison.score(firm) < comparison.threshold else fit


def _at_limits(fit: CandidateFit, names: Collection[str]) -> set[str]:
    """Return which of some candidates ended at a limit of their search."""
    return {candidate.name for candidate, _ in at_limits(fit)}.intersection(names)


def _held(search: Search, candidate: Candidate, level: float) -> Candidate:
    """Free the bristles of a friction whose level is roughly known."""
    own = search.settings.bristles
    soft, stiff, usual = (level / (share * _noise(search, candidate)) for share in (SEEN, own.smallest, own.initial))
    low, high = (bound * ratio for bound, ratio in zip((soft, stiff), own.relaxations, strict=True))
    bristles = (
        FreeParameter("stiffness", soft, stiff, signed=False, starts=(usual,), vanishes="never"),
        FreeParameter("damping", low, high, signed=False, starts=(own.relaxation * usual,)),
    )
    return replace(candidate, free=(*candidate.free, *bristles))


def _noise(search: Search, candidate: Candidate) -> float:
    """Return the noise of the encoder of a candidate's motor [rad or m]."""
    robot = search.null.model.robot
    return float(robot.encoder_noise[robot.joint_names.index(candidate.location)])
