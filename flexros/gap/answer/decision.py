"""The decision: verdict, rivals, groups and probabilities, from the fits of one log and their check on another."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.encoders.encoder_quantization import EncoderQuantization
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.kinds.base import PlacedEffect
from flexros.gap.answer.given_model import GivenModel
from flexros.gap.answer.strained_numbers import as_effects, strained_numbers
from flexros.gap.answer.unexplained_torques import unexplained_torques
from flexros.gap.fit.estimates import beyond_search, parameters_of, placed_effects
from flexros.gap.fit.torques.unknown_numbers import UnknownNumbers
from flexros.gap.fit.uncertainty.constancy import constancies
from flexros.gap.held_out.gap_floor import unknown_rounding
from flexros.gap.schema import EffectLocation
from flexros.gap.search.curves import curves_of
from flexros.gap.search.model_probability import RANKING, ModelComparison, allowing_for_doubt, compare

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.schema import CauseParameter, ToleranceSensitivity, Verdict
    from flexros.gap.search.forward_selection import Explanations
    from flexros.gap.settings import RankingSettings
    from flexros.record.quantization import Quantization


@dataclass(frozen=True, eq=False)
class Findings:
    """Fits of one log, and what the held-out log says of them.

    Attributes:
        model: The nominal model, with the numbers that the given one lacks.
        data: The fitted log.
        held: The held-out log.
        explanations: All fits, and the chosen one.
        held_comparison: The nominal model on the held-out log.
        held_chosen: The chosen explanation on the held-out log.
        given: The nominal model as it was given.
        unknown: The numbers that it lacks.
        quantizations: Encoders whose rounding matters and is not in the nominal model.
        tolerance: Relative tolerance of stiffness, inertia and damping [1]; those of the robot file where left out.
        settings: Thresholds and costs.
        complete: Whether the search was complete, so that no known effect explains what is left.
        names_by_tolerance: Effects that are named with the stated, halved or doubled tolerances.
        elsewhere: Explanations that are the most probable ones with other tolerances.
        withdrawn: Effects, effect@location, without which the held-out log is predicted better.
        fitted_around: Effects that ended at the last limit of their search, the others fitted again without them.
        torques_better: Whether the torques turned out better than assumed, and what is left is within what was.
        stop: Asked by the fits of the answer after each iteration; True ends them where they are.
    """

    model: RobotWithEffects
    data: FitData
    held: FitData
    explanations: Explanations
    held_comparison: ModelComparison
    held_chosen: CandidateFit
    given: RobotWithEffects
    unknown: UnknownNumbers = field(default_factory=UnknownNumbers)
    quantizations: tuple[Quantization, ...] = ()
    tolerance: Mapping[str, float] = field(default_factory=dict)
    settings: RankingSettings = RANKING
    complete: bool = True
    names_by_tolerance: tuple[ToleranceSensitivity, ...] = ()
    elsewhere: tuple[CandidateFit, ...] = ()
    withdrawn: tuple[str, ...] = ()
    fitted_around: tuple[str, ...] = ()
    torques_better: bool = False
    stop: Callable[[], bool] = lambda: False

    @cached_property
    def as_given(self) -> GivenModel:
        """The nominal model without the numbers that it lacks."""
        return GivenModel(self)

    @cached_property
    def beyond_search(self) -> frozenset[str]:
        """Effects of the chosen explanation, effect@location, whose size ended at the limit of its search."""
        return beyond_search(self.explanations.chosen)

    @cached_property
    def repaired(self) -> CandidateFit:
        """The chosen explanation without these effects: what the patch holds of it."""
        chosen = self.explanations.chosen
        if not self.beyond_search:
            return chosen
        return replace(chosen, theta=chosen.switched_off(self.beyond_search))

    def sizes(self, fit: CandidateFit) -> list[dict[str, CauseParameter]]:
        """Return the parameters of every effect of a fit, with what both logs say of their deviations."""
        return parameters_of(fit, self.data, self.settings, self.held)

    @property
    def quantized(self) -> dict[str, Quantization]:
        """The same encoders by effect@location."""
        names = self.model.robot.joint_names
        return {f"{EncoderQuantization.name}@{names[one.motor]}": one for one in self.quantizations}


def findings_of(
    model: RobotWithEffects,
    data: FitData,
    held: FitData,
    explanations: Explanations,
    *,
    given: RobotWithEffects | None = None,
    unknown: UnknownNumbers | None = None,
    tolerance: Mapping[str, float] | None = None,
    settings: RankingSettings = RANKING,
    complete: bool = True,
    names_by_tolerance: tuple[ToleranceSensitivity, ...] = (),
    elsewhere: tuple[CandidateFit, ...] = (),
    withdrawn: tuple[str, ...] = (),
    fitted_around: tuple[str, ...] = (),
    torques_better: bool = False,
    stop: Callable[[], bool] = lambda: False,
) -> Findings:
    """Evaluate the nominal model and the chosen explanation on the held-out log; arguments as in `Findings`."""
    return Findings(
        model=model,
        data=data,
        held=held,
        explanations=explanations,
        held_comparison=compare(held, on_held_out(explanations.null, held), settings=settings),
        held_chosen=on_held_out(explanations.chosen, held),
        given=given or model,
        unknown=unknown or UnknownNumbers(),
        quantizations=unknown_rounding(model, data.measurement),
        tolerance=dict(tolerance or {}),
        settings=settings,
        complete=complete,
        names_by_tolerance=names_by_tolerance,
        elsewhere=elsewhere,
        withdrawn=withdrawn,
        fitted_around=fitted_around,
        torques_better=torques_better,
        stop=stop,
    )


def on_held_out(fit: CandidateFit, held: FitData) -> CandidateFit:
    """Evaluate the sum of squares of a fit in the held-out log, infinite where the prediction diverges."""
    squares = float(np.sum(fit.residual(held) ** 2))
    return replace(fit, chi2=squares if np.isfinite(squares) else np.inf)


def level_of_positions(fit: CandidateFit, data: FitData) -> float:
    """Return the mean squared error of predicted positions of one sample over its floor [1].

    Errors of the torques that a fit weighs as well are over less than their tolerance.

    Args:
        fit: The fit.
        data: The log.
    """
    positions = data.without_torques
    return on_held_out(fit, positions).chi2 / positions.n_values


def held_out_gap(findings: Findings) -> bool:
    """Return whether the nominal model leaves more than noise in the held-out log."""
    comparison = allowing_for_doubt(findings.held_comparison, findings.held)
    return comparison.significant(comparison.null)


def held_out_gain(fit: CandidateFit, findings: Findings) -> float:
    """Return twice the gain in log-likelihood over the nominal model in the held-out log [1]; -inf if it diverges."""
    held = on_held_out(fit, findings.held)
    return findings.held_comparison.gain(held) if np.isfinite(held.chi2) else -np.inf


def verdict_of(
    findings: Findings,
    left: float = 1.0,
    with_tolerance: float | None = None,
    *,
    worse: bool = False,
    moving_on: bool = False,
    closed: float = 0.0,
) -> Verdict:
    """Return the verdict.

    A real machine has no gap where its errors are within the floors that an explanation may leave: the tolerance of
    torques is in the floor as white torque, and real errors last.

    A curve names where something is, but no law: what it explains is explained in part at best. An explanation may be
    as good as its form allows and still leave much more than noise: then it is one in part as well. So it is where it
    leaves torques that errors of positions do not show, or predicts hardly better than at constant speed.

    Args:
        findings: Fits of one log, and what the held-out log says of them.
        left: Mean squared prediction error 0.1 s ahead that the chosen explanation leaves in the held-out log, over its
            floor [1].
        with_tolerance: What torques that are off by their tolerance leave there [1]; None where they are exact.
        worse: Whether the chosen explanation predicts that log worse 0.1 s ahead than the nominal model: then it is no
            part of the truth, however certain it is in the fitted log.
        moving_on: Whether the chosen explanation predicts a motor hardly better than at constant speed, by a much
            larger inertia.
        closed: Lower end of the interval of the share of the gap that the chosen explanation closes there [1].
    """
    explanations, comparison = findings.explanations, findings.explanations.comparison
    if not explanations.detected:
        fitted = allowing_for_doubt(comparison, findings.data)
        shows = fitted.significant(explanations.chosen) or held_out_gap(findings)
        measured = not findings.data.record.premises.floor_is_noise
        if shows and not (measured and _within_floor(findings, left, with_tolerance)):
            return "unknown_effect"
        return "explained" if findings.quantizations else "no_gap"
    if worse and held_out_gap(findings):
        return "unknown_effect"
    confirmed = findings.held_comparison.adequate(findings.held_chosen, elsewhere=True)
    lawful = not curves_of(explanations.chosen.hypothesis)
    if comparison.adequate(explanations.chosen) and confirmed and lawful:
        if rivals_of(explanations, findings.settings, findings.elsewhere):
            return "ambiguous"
        within = _within_floor(findings, left, with_tolerance) and not unexplained_torques(findings)
        return "explained" if within and not moving_on else "partly_explained"
    return "partly_explained" if _partly(findings, closed) else "unknown_effect"


def _within_floor(findings: Findings, left: float, with_tolerance: float | None) -> bool:
    """Return whether the chosen explanation leaves about the floor: on a real machine, of noise and tolerance.

    There predictions of one sample, in both logs, must be within it as well as those 0.1 s ahead: the former show fast
    errors, the latter slow ones. With torques that turned out better than assumed, `are_better` has asked for the
    former: what counted as no gap with fewer effects is none with more.
    """
    floors, measured = findings.settings.floors, not findings.data.record.premises.floor_is_noise
    if measured and not findings.torques_better and max(_levels(findings)) > floors:
        return False
    return left <= floors * (with_tolerance or 1.0)


def _levels(findings: Findings) -> tuple[float, float]:
    """Return what the chosen explanation leaves of predictions of one sample in both logs, over their floor [1]."""
    fitted = level_of_positions(findings.explanations.chosen, findings.data)
    return fitted, findings.held_comparison.level(findings.held_chosen)


def _partly(findings: Findings, closed: float) -> bool:
    """Return whether effects are certain and confirmed on held-out data although they leave more than the floor.

    Of a real machine, either horizon confirms them: one sample ahead, where the torques of a slow recorder say little
    of what acted between its samples, or 0.1 s ahead, by which the gap is stated.

    On an exact model, a single effect that leaves more than its model-form error is the best imitation of an unknown
    one, unless its size is constant over the log. Several effects that are each indispensable with all others in place
    are part of the truth, and so is the best one on a real machine, where never everything is modelled, or where
    further ones could not be tried.
    """
    chosen, settings = findings.explanations.chosen, findings.settings
    measured = not findings.data.record.premises.library_is_complete
    if not (
        findings.held_comparison.remainder(findings.held_chosen) < 1 - settings.confirmed_share
        or (measured and closed > settings.confirmed_share)
    ):
        return False
    if len(chosen.hypothesis) > 1 or measured or not findings.complete:
        return True
    return min(constancies(chosen, findings.data, settings).values()) >= settings.constant


def rivals_of(
    explanations: Explanations, settings: RankingSettings = RANKING, elsewhere: Collection[CandidateFit] = ()
) -> tuple[CandidateFit, ...]:
    """List the explanations with other effects whose probability is within a factor of that of the chosen one.

    Args:
        explanations: The explanations.
        settings: The factor.
        elsewhere: Explanations that lead with other tolerances, which are rivals whatever their probability.
    """
    if not explanations.detected:
        return ()
    probabilities = dict(zip(explanations.rivals, explanations.probabilities))
    chosen = explanations.chosen
    return tuple(
        fit
        for fit, probability in probabilities.items()
        if fit.names != chosen.names and (fit in elsewhere or probability * settings.rival >= probabilities[chosen])
    )


def best_rival(explanations: Explanations) -> CandidateFit | None:
    """Return the most probable explanation with other effects than the chosen one; None without any."""
    if not explanations.detected:
        return None
    return next((fit for fit in explanations.rivals if fit.names and fit.names != explanations.chosen.names), None)


def groups_of(
    explanations: Explanations, settings: RankingSettings = RANKING, elsewhere: Collection[CandidateFit] = ()
) -> tuple[tuple[EffectLocation, ...], ...]:
    """Collect the effects that replace one another in rival explanations; arguments as for `rivals_of`.

    An effect that a rival has or lacks beside all others is a group alone: the log does not say whether it is there.
    """
    chosen = [candidate.name for candidate in explanations.chosen.hypothesis]
    groups: dict[str, list[str]] = {}
    for rival in rivals_of(explanations, settings, elsewhere):
        others = sorted(rival.names - set(chosen))
        for name in chosen:
            if name not in rival.names:
                group = groups.setdefault(name, [name])
                group += [other for other in others if other not in group]
        if rival.names > set(chosen):
            groups |= {other: [other] for other in others if not any(other in group for group in groups.values())}
    return tuple(tuple(effect_location(name) for name in group) for group in groups.values())


def probability_of(name: str, findings: Findings, verdict: Verdict) -> float:
    """Add up the probabilities of all explanations that contain an effect at a location [1].

    Where none explains the gap, return the probability that the effect is part of it all the same. So it is with an
    effect of a size that it hardly ever has beside which a part of the gap is left: the best imitation of a force that
    is not in the library.

    Args:
        name: Name of the candidate, effect@location.
        findings: The fits.
        verdict: Their verdict.
    """
    explanations = findings.explanations
    pairs = zip(explanations.rivals, explanations.probabilities)
    total = float(min(1.0, sum(probability for fit, probability in pairs if name in fit.names)))
    imitates = verdict == "unknown_effect" or (verdict == "partly_explained" and _hardly_ever(name, findings))
    return total * (findings.settings.part_of_unknown if imitates else 1.0)


def _hardly_ever(name: str, findings: Findings) -> bool:
    """Return whether an effect of the chosen explanation has a size that it hardly ever has."""
    placed = placed_effects(findings.explanations.chosen)
    return any(one.effect.stands_for() and f"{one.effect.name}@{one.location}" == name for one in placed)


def rank_key(name: str, findings: Findings, verdict: Verdict) -> tuple[float, float, float]:
    """Return the sort key of an effect among those that close as much of the held-out gap, see `in_order`.

    It is by probability to the hundredth, then by what is lost without it in the fitted log.

    Lost is the rise of the mean squared prediction error when the chosen explanation does without it; for the rounding
    of an encoder, which is certain, its variance over that of the noise.

    Args:
        name: Name of the candidate, effect@location.
        findings: The fits.
        verdict: Their verdict.
    """
    quantization = findings.quantized.get(name)
    if quantization is not None:
        noise = float(findings.model.robot.encoder_noise[quantization.motor])
        return -1.0, -(quantization.step**2) / 12 / noise**2, -1.0
    explanations, level = findings.explanations, findings.explanations.comparison.level
    chosen = explanations.chosen
    rest = chosen.names - {name}
    without = min(level(fit) for fit in explanations.rivals if fit.names <= rest)
    lost = without - level(chosen) if name in chosen.names else 0.0
    probability = probability_of(name, findings, verdict)
    return -round(probability, 2), -lost, -probability


def repair_of(findings: Findings) -> tuple[PlacedEffect, ...]:
    """Return the effects that repair the model: unknown numbers, the chosen explanation, and rounding of encoders.

    Numbers of the model that the explanation moves far out of their tolerance belong to it: sizes are those beside
    them. An effect at the limit of its search is left out. One whose deviation is above its size stays: the search
    keeps an effect only where more than chance is lost without it, and what it takes up would else spoil the others.
    """
    names = findings.model.robot.joint_names
    rounding = (PlacedEffect(EncoderQuantization(step=one.step), names[one.motor]) for one in findings.quantizations)
    chosen = findings.explanations.chosen
    numbers = findings.unknown.fitted(chosen)
    every = zip(chosen.hypothesis, placed_effects(chosen), strict=True)
    placed = [one for candidate, one in every if candidate.name not in findings.beyond_search]
    for number in [one for one in numbers if isinstance(one.effect, ViscousFriction)]:
        beside = [one for one in placed if one.location == number.location and isinstance(one.effect, ViscousFriction)]
        if beside:  # found beside the friction that the model was given instead of that of its file
            placed[placed.index(beside[0])] = _together(number, beside[0])
            numbers = tuple(one for one in numbers if one is not number)
    repair = (*numbers, *placed, *rounding)
    strained = strained_numbers(findings) if placed else {}
    return (*repair, *as_effects(findings.given.robot, repair, strained))


def _together(one: PlacedEffect, other: PlacedEffect) -> PlacedEffect:
    """Return the viscous friction of two at a motor, of which the first has no asymmetry."""
    assert isinstance(one.effect, ViscousFriction)
    assert isinstance(other.effect, ViscousFriction)
    total = one.effect.coefficient + other.effect.coefficient
    return replace(other, effect=other.effect.model_copy(update={"coefficient": total}))


def effect_location(name: str) -> EffectLocation:
    """Split the name of a candidate, effect@location."""
    effect, _, location = name.partition("@")
    return EffectLocation(effect=effect, location=location)
