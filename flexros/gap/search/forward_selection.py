"""Forward selection: single effects, then further ones for as long as they remove what is left."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.candidates.candidate import names_of
from flexros.gap.fit.candidate_fit import best_of_each
from flexros.gap.fit.limits import at_limits
from flexros.gap.search.common_factor import with_other_scales
from flexros.gap.search.common_scale import with_common_scale
from flexros.gap.search.curve_candidates import within_motion
from flexros.gap.search.curves import curves_of, in_place_of_laws, with_constants, with_curves
from flexros.gap.search.elimination.clear_sizes import with_asymmetry, with_dropped, with_dropped_again, without_unclear
from flexros.gap.search.elimination.reduce import one_by_one, reduced
from flexros.gap.search.exchange import exchanged, one_delay
from flexros.gap.search.growth import extended, promises, resumed, tidied, with_more
from flexros.gap.search.periodic.lines import beside_line
from flexros.gap.search.regrouping import with_gains, without_tangled
from flexros.gap.search.richer_laws import with_richer_laws, with_simpler_effects
from flexros.gap.search.within_floor import grown_to_floor, grown_within_floor, with_slant
from flexros.gap.search.within_tolerance import with_far_numbers, without_slight_friction, without_tolerated
from flexros.gap.search.worth import compared, in_vain, simplest, strains, worth

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.directions import Directions
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.model_probability import ModelComparison


PAIR = 2
"""Effects up to which every explanation with fewer of them is a rival [1]."""
LOST = 0.5
"""Share of the fall of the sum of squares below which an explanation that ended at limits is lost [1] (chosen)."""
EARLIER = 4
"""Earlier explanations that are tried in place of one that ended at a limit [1] (chosen)."""
AT_END = (
    without_tolerated,
    with_far_numbers,
    without_slight_friction,
    without_tangled,
    without_unclear,
    with_other_scales,
    with_common_scale,
    with_constants,
)
"""Steps at the end of a search, in their order."""


@dataclass(frozen=True, eq=False)
class Explanations:
    """All fits of a log, and the chosen one.

    Attributes:
        comparison: All fits, each hypothesis once, compared.
        chosen: The explanation; the null fit where no effect was detected.
        rivals: Fits with no more effects than the chosen one, and the null fit, by probability.
        probabilities: Their probabilities [1], shape (n_rivals,).
        detected: Whether an effect was detected.
        beside: The log without the line that hid effects; None without one.
    """

    comparison: ModelComparison
    chosen: CandidateFit
    rivals: tuple[CandidateFit, ...]
    probabilities: FloatArray
    detected: bool
    beside: FitData | None = None

    @property
    def null(self) -> CandidateFit:
        """The fit of the nominal model."""
        return self.comparison.null

    @property
    def remainder(self) -> float:
        """Share of the gap that the chosen explanation leaves [1]; zero where what is left is not significant."""
        return self.comparison.remainder(self.chosen)


def explain(search: Search, promised: float = 0.0) -> Explanations:
    """Search a log for causes.

    Every effect alone, then forward selection: several candidates at a time whose gains add up, all fitted again
    together, and those that turn out to remove little left out again. What counts is the removal of an effect at the
    end, with all others in place: at the beginning each of many true effects removes only a small part of the gap.
    A search that is resumed begins with the explanation that it has, and exchanges what that took in place of others;
    it ends early where it will not leave noise, see `in_vain`.

    Args:
        search: The log, the nominal model fitted to it and the settings.
        promised: Share of what the base leaves that candidates must promise to remove together, else it is the
            explanation [1].

    Returns:
        All fits and the chosen explanation.
    """
    settings = search.settings.search
    null = search.null.fit
    directions = search.directions(search.candidates())
    if promised and not promises(search, search.base, directions, promised):
        return explanations_of(search, compared(search, [search.base]), search.base, detected=True)
    if search.from_torques or search.resumed:
        fits = [search.base]
    else:
        fits = search.singles([*directions, *search.directions(search.harmonics(null))])
    comparison = compared(search, fits)
    if not comparison.detected:
        return explanations_of(search, comparison, null, detected=False)
    chosen = simplest(search, comparison, comparison.ranked(fits)[0], fits)
    beside = beside_line(search, chosen, null)  # no effect removes it: before others imitate it
    if beside is not None:
        return explain(beside)
    if search.from_torques:
        chosen = reduced(search, chosen, fits, settings.removed_by_step)
        chosen = with_asymmetry(search, chosen, fits)
        dropped = [one for one in search.candidates() if one.name in search.of_torques - chosen.names]
        directions += search.directions(dropped, chosen)  # beside another effect they may be needed
    first = chosen
    chosen = extended(search, chosen, directions, fits)
    beside = beside_line(search, chosen)
    if beside is not None:
        return explain(beside)
    if in_vain(search, chosen) and chosen.names == first.names:
        return explanations_of(search, compared(search, best_of_each(fits)), chosen, detected=True)
    if search.from_torques and chosen.names != first.names:
        chosen = with_dropped(search, chosen, fits)
    slanted = with_slant(search, chosen, fits)
    if slanted is not chosen:
        chosen = extended(search, slanted, search.directions(search.candidates(), slanted), fits, again=True)
    if len(chosen.hypothesis) > 1 or search.resumed:
        before = chosen
        chosen = resumed(search, chosen, tidied(search, chosen, directions, fits), directions, fits)
        if in_vain(search, chosen):
            return explanations_of(search, compared(search, best_of_each(fits)), chosen, detected=True)
        chosen = with_dropped_again(search, before, chosen, fits)
    elif search.deadline.over:
        chosen = search.completed(chosen)
        fits.append(chosen)
    chosen = _with_other_forms(search, first, chosen, directions, fits)
    for step in AT_END:
        chosen = step(search, chosen, fits)
    fits.append(search.beside_jumps(chosen))
    comparison = compared(search, best_of_each(fits))
    (chosen,) = (fit for fit in comparison.fits if fit.names == chosen.names)
    return _pruned(search, explanations_of(search, comparison, chosen, detected=True))


def _with_other_forms(
    search: Search,
    first: CandidateFit,
    chosen: CandidateFit,
    directions: Sequence[Directions],
    fits: list[CandidateFit],
) -> CandidateFit:
    """Take richer laws and curves in place of effects where these explain more, and simpler ones where they are enough.

    Args:
        search: The search.
        first: The explanation before further effects were added.
        chosen: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
    """
    chosen = one_delay(search, with_gains(search, chosen, fits), fits)
    chosen, richer = with_richer_laws(search, chosen, fits)
    grown = grown_to_floor(search, chosen, directions, fits)
    if grown is not chosen:
        chosen, richer = grown, None
    curved = with_curves(search, chosen, directions, fits)
    if curved is not chosen:
        chosen = _beside_curves(search, first, curved, directions, fits)
    else:  # what no law explains would be imitated there
        grown = grown_within_floor(search, chosen, directions, fits, richer)
        if grown is not chosen:
            chosen = exchanged(search, grown, directions, fits)
            chosen = chosen if chosen is grown else one_by_one(search, chosen, fits)
    return _simplified(search, chosen, directions, fits)


def _simplified(
    search: Search, chosen: CandidateFit, directions: Sequence[Directions], fits: list[CandidateFit]
) -> CandidateFit:
    """Take simpler effects in place of rich ones, and add those that did not show beside these.

    Beside a law that takes the place of a curve, what made up for the curve gives way, and the search goes on.
    """
    simple = with_simpler_effects(search, chosen, fits)
    if simple.names == chosen.names:
        return simple
    if search.from_torques and len(curves_of(simple.hypothesis)) < len(curves_of(chosen.hypothesis)):
        around = search.directions(search.candidates(), simple)
        simple = extended(search, with_dropped(search, simple, fits), around, fits, again=True)
        simple = tidied(search, simple, around, fits)
    return grown_to_floor(search, simple, directions, fits)


def _beside_curves(
    search: Search,
    first: CandidateFit,
    curved: CandidateFit,
    directions: Sequence[Directions],
    fits: list[CandidateFit],
) -> CandidateFit:
    """Leave out the laws that imitated what curves explain now, and add those that were hidden behind it.

    Laws that were found without the curves may all be imitations of them. So the curves are also tried with the laws
    that the search began with, less those at their motors that they do not contain. Of two explanations of which one
    has all effects of the other, the larger one must be worth them.

    Args:
        search: The search.
        first: The explanation before further effects were added.
        curved: The explanation with curves.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
    """
    removed = search.settings.search.removed
    alternatives = [(curved, directions)]
    rest = in_place_of_laws(search, first, curved)
    curves = names_of(tuple(curves_of(curved.hypothesis)))
    if rest.names != curved.names - curves and not search.deadline.stops():
        other = with_curves(search, rest, directions, fits, curves)
        if other is not rest:
            alternatives.append((other, search.directions(search.candidates(), other)))
    found = []
    for fit, candidates in alternatives:
        small = reduced(search, fit, fits, removed)
        for _ in range(search.settings.search.rounds):
            grown = None if search.deadline.stops() else with_more(search, small, candidates, [])
            if grown is None or not worth(search, compared(search, best_of_each(fits)), small, grown, removed):
                break
            fits.append(search.completed(within_motion(search, grown)))
            before, small = small, reduced(search, fits[-1], fits, removed)
            if small.names == before.names:
                break
        found.append(small)
    comparison = compared(search, best_of_each(fits))
    best, *others = comparison.ranked(found)
    for fewer in others:
        if fewer.names < best.names and not worth(search, comparison, fewer, best, removed):
            best = fewer
    return best


def _pruned(search: Search, explanations: Explanations) -> Explanations:
    """Prune the parameters of all likely explanations and carry them to their end, so that none has a handicap."""
    likely = [
        fit
        for fit, probability in zip(explanations.rivals, explanations.probabilities)
        if probability > search.settings.ranking.likely or fit is explanations.chosen
    ]
    pruned = {fit: search.at_its_end(search.pruned(fit)) for fit in likely}
    chosen = search.within_limits(pruned[explanations.chosen])
    fits = [pruned.get(fit, fit) for fit in explanations.comparison.fits if fit is not explanations.chosen]
    if chosen.predictor.n_effect < explanations.chosen.predictor.n_effect:  # without a parameter one may be needless
        chosen = search.within_limits(_reduced_at_end(search, chosen, fits))
        chosen = search.within_limits(_best_within_limits(search, chosen, fits))
    if not chosen.hypothesis:
        return explanations_of(search, compared(search, fits), search.null.fit, detected=False)
    comparison = compared(search, [*(fit for fit in fits if fit.names != chosen.names), chosen])
    if chosen.names != explanations.chosen.names:  # beside what was left out, another effect may have seemed better
        as_many = [fit for fit in comparison.fits if len(fit.hypothesis) == len(chosen.hypothesis)]
        chosen = comparison.ranked([fit for fit in as_many if not at_limits(fit)] or [chosen])[0]
    return explanations_of(search, comparison, chosen, detected=True)


def _best_within_limits(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Return what is left of an explanation without what ended at a limit, or an earlier fit that explains more.

    An earlier one may end at a limit too, once what is needless is left out: then the next one is tried.

    Args:
        search: The search.
        chosen: What is left of the explanation.
        fits: The other fits; new ones are appended.
    """
    removed = search.settings.search.removed
    earlier = sorted((fit for fit in fits if fit.hypothesis and not at_limits(fit)), key=lambda fit: fit.chi2)
    found = [chosen]

    def worth_more(one: CandidateFit) -> bool:
        least = min(found, key=lambda fit: fit.chi2)
        return worth(search, compared(search, [least, one]), least, one, removed)

    for best in earlier[:EARLIER]:
        if not worth_more(best):
            break
        small = _reduced_at_end(search, search.within_limits(search.pruned(best)), fits)
        found.append(search.within_limits(small))  # what was left out may have kept another one from its limit
    laws = next((fit for fit in earlier if not curves_of(fit.hypothesis)), chosen)
    least = min(fit.chi2 for fit in found)
    if search.null.fit.chi2 - least < LOST * (search.null.fit.chi2 - laws.chi2) and worth_more(laws):
        return laws  # all of it is needed to stay within the limits
    return min((fit for fit in found if fit.hypothesis), key=lambda fit: fit.chi2, default=chosen)


def _reduced_at_end(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Leave out needless effects at the end of a search: of a measured log each after a fit without it."""
    if search.torques_decide:
        return one_by_one(search, fit, fits)
    return reduced(search, fit, fits, search.settings.search.removed)


def _left_behind(search: Search, comparison: ModelComparison, fit: CandidateFit, chosen: CandidateFit) -> bool:
    """Return whether a fit is one that the search of a simulated log went on from, and no doubt about its end.

    Exchanges of single effects are fitted around the chosen explanation, and the form of the effects is the doubt
    about these. A fit with two and more other effects comes from the way there. Where it leaves clearly more, the share
    of the gap of all its effects that their form may miss would make it as probable.

    Args:
        search: The search.
        comparison: All fits.
        fit: A fit with as many effects as the chosen one.
        chosen: The chosen explanation.
    """
    if not search.premises.library_is_complete or len(chosen.names - fit.names) < PAIR:
        return False
    clearly = comparison.level(fit) - comparison.level(chosen) > search.settings.search.little
    return clearly and worth(search, comparison, fit, chosen, search.settings.search.removed)


def _with_shared_effects(
    search: Search, comparison: ModelComparison, rivals: Sequence[CandidateFit]
) -> ModelComparison:
    """Return a comparison with fits of what likely rivals share with the most probable explanation.

    The form error of the effects in which two explanations differ is a share of what these close beside the effects
    that both have. Where those were never fitted alone, a part of them stands for them, and what the others close
    counts as well: then a small effect of a crowd seems as doubtful as the largest one.
    """
    for _ in range(search.settings.search.rounds):
        probabilities = comparison.probabilities(rivals)
        best = rivals[int(np.argmax(probabilities))]
        likely = probabilities > search.settings.ranking.likely
        shared = {fit.names & best.names for fit, one in zip(rivals, likely, strict=True) if one}
        lacking = shared - {frozenset(), *(fit.names for fit in comparison.fits)}
        if not lacking or search.deadline.stops():
            break
        fitted = [search.without(best, *(best.names - names)) for names in sorted(lacking, key=sorted)]
        comparison = replace(comparison, fits=(*comparison.fits, *fitted))
    return comparison


def explanations_of(
    search: Search, comparison: ModelComparison, chosen: CandidateFit, *, detected: bool
) -> Explanations:
    """Distribute probability over all explanations with no more effects than the chosen one."""
    most = max(1, len(chosen.hypothesis))
    small = [fit for fit in comparison.fits if len(fit.hypothesis) <= most]
    removed = search.settings.search.removed

    def rivals_with(fit: CandidateFit) -> bool:
        if fit is chosen:
            return True
        if at_limits(fit) and not at_limits(chosen):
            return False  # the chosen one was taken in its place, as what ended at a limit is no finding
        if not search.premises.floor_is_noise and strains(search, comparison, chosen, fit):
            return False  # an error that the chosen one names is not within tolerance
        fewer = len(fit.hypothesis) < len(chosen.hypothesis)
        doubtless = (most > PAIR and fewer) or not search.premises.floor_is_noise
        if doubtless and worth(search, comparison, fit, chosen, removed):
            # the form error of the large effects of a crowd is no doubt about the small ones, nor is the floor of a
            # real machine one about what is worth it within
            return False
        if most > PAIR and not fewer and _left_behind(search, comparison, fit, chosen):
            return False
        return simplest(search, comparison, fit, small) is fit

    rivals = [comparison.null, *filter(rivals_with, small)]
    comparison = _with_shared_effects(search, comparison, rivals)
    probabilities = comparison.probabilities(rivals)
    order = np.argsort(-probabilities, kind="stable")
    return Explanations(
        comparison,
        chosen,
        tuple(rivals[index] for index in order),
        probabilities[order],
        detected,
        None if search.data.line is None else search.data,
    )
