"""Parameters of a fit that ended at a limit of their search."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit

ENDED, MOSTLY = 0.99, 0.5
"""Deviation over the largest that is searched from which it ended there, and share of a number's change by such ones
from which its value is theirs [1] (chosen)."""


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


def numbers_at_limits(fit: CandidateFit) -> frozenset[str]:
    """Return the names of tolerated numbers that a fit moved mostly along directions in which its search ended.

    Args:
        fit: The fit.
    """
    tolerance, free = fit.predictor.tolerance, fit.deviations
    ended = np.where(np.abs(free) > ENDED * tolerance.farthest, free, 0.0)
    by_limits, moved = (np.abs(tolerance.by_name(one)) for one in (ended, free))
    mostly = (by_limits > 0) & (by_limits > MOSTLY * moved)
    return frozenset(name for name, limited in zip(tolerance.names, mostly, strict=True) if limited)
