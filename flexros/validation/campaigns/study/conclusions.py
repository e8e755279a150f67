"""The conclusions of Paper A beside what the simulated study shows: which hold here, which do not, and why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.campaigns.study.choices import REFERENCE
from flexros.validation.campaigns.study.figures import of_gears, shares, springs

if TYPE_CHECKING:
    from flexros.validation.campaigns.study.figures import EstimatorShare
    from flexros.validation.campaigns.study.jobs import Study

SIGNIFICANT = 2.0
"""Standard errors by which two shares must differ to count as different (chosen)."""

GOOD_INDICATION = 2.0
"""Largest ratio of theoretical and empirical deviation, either way, that is a good indication (chosen)."""

COMPARISONS = (
    ("the LLS estimator is superior to the NLS estimator", "LLS15U", "NLS15U"),
    ("more than one position is needed", "LLS15U", "LLS1U"),
    ("phase information improves the estimate", "LLS15U", "LLSM15U"),
    ("user-defined weights work much better than the optimal weights", "LLS15U", "LLS15O"),
)
"""Conclusions about shares of reasonable models: the sentence, the better estimator and the other one."""

CAUSES = (
    "Why they differ, most likely (not tested by an experiment of its own). The measured robot of this study has its "
    "springs at the very places where the model has them; it differs from the model by friction, hardening and ripple. "
    "The arm of the paper is a continuum that no such model describes in every detail, its responses have bias errors "
    "from nonlinearities and closed-loop data, and the paper names this bias as the reason for rough weights. With "
    "little bias, the optimal weights are nearly those of the theorem, and the user's weights have no advantage. "
    "One position suffices here for the same reason: it is the most informative of thousands, and its responses "
    "determine springs that are where the model has them. What one position loses here is accuracy: see the costs and "
    "the dampers above. Shares of starts also measure the search: with bounds and limited steps it finds the minimum "
    "from starts from which the general-purpose search does not.",
    "So these conclusions are neither confirmed nor refuted here: the robot lacks the model error on which they rest.",
)
"""Text below the table where a conclusion is not reproduced."""


@dataclass(frozen=True)
class Conclusion:
    """One conclusion of the paper and what this study says about it.

    Attributes:
        claim: The conclusion, as the paper has it.
        here: The figures of this study.
        search: Whether it holds with the search of FlexROS; None where the search does not matter.
        peer: Whether it holds with the general-purpose search; None where the search does not matter.
        holds: Whether it holds with every search that was tried.
    """

    claim: str
    here: str
    search: bool | None
    peer: bool | None
    holds: bool


def conclusions(study: Study) -> tuple[Conclusion, ...]:
    """Compare each conclusion of Paper A, section 7, with the study, in the order of the paper."""
    by_name = {share.kind.name: share for share in shares(study)}
    starts = len(study.runs[REFERENCE].user_cost)
    peers = int(np.count_nonzero(~np.isnan(study.runs[REFERENCE].peer_cost)))
    compared = [
        _comparison(claim, by_name[better], by_name[other], starts, peers) for claim, better, other in COMPARISONS
    ]
    theory = study.theory
    gears, stiff = of_gears(study), np.isin(np.arange(len(theory)), springs(study))
    ratio = study.spread / theory
    return (
        *compared,
        _easier("gearbox parameters are easier to estimate than those of the arm", study, gears, "gears", "arm"),
        _easier("springs are easier to estimate than dampers", study, stiff, "springs", "dampers"),
        _plain(
            "the theoretical uncertainty indicates the quality of the estimates",
            f"redrawn over theory {np.min(ratio):.2f} to {np.max(ratio):.2f}",
            bool(np.all((ratio < GOOD_INDICATION) & (ratio > 1.0 / GOOD_INDICATION))),
        ),
    )


def conclusion_rows(study: Study) -> list[str]:
    """Return the conclusions as rows of a table, with the accuracy of the compared estimators and the causes below."""
    rows = ["| conclusion of the paper | here | with our search | with BFGS |", "|---|---|---|---|"]
    for found in conclusions(study):
        rows.append(f"| {found.claim} | {found.here} | {_word(found.search, found)} | {_word(found.peer, found)} |")
    missed = [found.claim for found in conclusions(study) if not found.holds]
    rows += [
        "",
        f"'Yes' for shares: they differ by more than {SIGNIFICANT:g} standard errors. Not reproduced with every "
        f"search: {'; '.join(missed) or 'none'}.",
        "",
        "| estimator | lowest cost over that of all | springs off by | dampers off by |",
        "|---|---|---|---|",
        *_accuracy_rows(study),
        "",
        "Medians over the parameters of the estimator's best model, against the best model of all.",
    ]
    for cause in CAUSES if missed else ():
        rows += ["", cause]
    return rows


def _comparison(claim: str, better: EstimatorShare, other: EstimatorShare, starts: int, peers: int) -> Conclusion:
    search = _clearly_larger(better.reasonable, other.reasonable, starts)
    peer = _clearly_larger(better.peer, other.peer, peers)
    here = (
        f"reasonable {better.kind.name} {better.reasonable:.0%}, {other.kind.name} {other.reasonable:.0%}; by BFGS "
        f"{better.peer:.0%}, {other.peer:.0%}; published {better.kind.published_reasonable:.0%}, "
        f"{other.kind.published_reasonable:.0%}"
    )
    return Conclusion(claim, here, search, peer, search and peer)


def _clearly_larger(share: float, other: float, number: int) -> bool:
    """Tell whether a share exceeds another one by `SIGNIFICANT` standard errors of their difference."""
    variance = (share * (1.0 - share) + other * (1.0 - other)) / max(number, 1)
    return share - other > SIGNIFICANT * float(np.sqrt(variance)) and share > other


def _easier(claim: str, study: Study, chosen: np.ndarray, name: str, rest: str) -> Conclusion:
    first, second = float(np.median(study.theory[chosen])), float(np.median(study.theory[~chosen]))
    here = f"median theoretical deviation: {name} {first:.2%}, {rest} {second:.2%}"
    return _plain(claim, here, first < second)


def _plain(claim: str, here: str, holds: bool) -> Conclusion:
    return Conclusion(claim, here, None, None, holds)


def _word(verdict: bool | None, found: Conclusion) -> str:
    return "yes" if (found.holds if verdict is None else verdict) else "no"


def _accuracy_rows(study: Study) -> list[str]:
    lowest = min(float(np.min(run.user_cost)) for run in study.runs.values())
    stiff = np.isin(np.arange(len(study.theory)), springs(study))
    rows = []
    for name, run in study.runs.items():
        best = int(np.argmin(run.user_cost))
        off = np.abs(run.values[best] / study.best.values - 1.0)
        medians = f"{np.median(off[stiff]):.2%} | {np.median(off[~stiff]):.2%}"
        rows.append(f"| {name} | {run.user_cost[best] / lowest:.3f} | {medians} |")
    return rows
