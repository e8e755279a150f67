"""Parameters of a fit that ended at a limit of their search."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit


def at_limits(fit: CandidateFit) -> list[tuple[Candidate, str]]:
    """List the parameters of a fit that ended at a limit of their search, with their effects."""
    return [
        (candidate, name)
        for candidate, values in zip(fit.hypothesis, fit.predictor.values(fit.theta))
        for name in sorted(candidate.at_limit(values))
    ]


def ended_at_last(fit: CandidateFit) -> set[str]:
    """Return the names of the effects of a fit whose sizes ended where their search cannot be widened.

    Args:
        fit: The fit.
    """
    return {
        one.name
        for one, name in at_limits(fit)
        if one.widened(name) is None and one.with_usual(name) is None and one.without_part(name) is None
    }
