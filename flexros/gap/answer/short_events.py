"""Short parts of a log that hold much of what an answer leaves: a push, a collision, a stop of a joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.gap.answer.decision import Findings
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData

WINDOW = 0.25
"""Length of the parts that are looked at [s] (chosen)."""
HELD, SHORT, FEW = 0.5, 0.06, 3
"""Share of what is left above the floor that a few parts hold, share of the log that they are at most, and their number
[1] (chosen): friction leaves something at every reversal."""
LEAST = 2.0
"""Mean squared prediction error over its floor from which it is looked for [1] (chosen)."""


def short_events(findings: Findings) -> list[str]:
    """Say when most of what is left happened, where that is short: it spoils the sizes of all effects."""
    found = {
        "": spans(findings.data, findings.explanations.chosen),
        "held-out log: ": spans(findings.held, findings.held_chosen),
    }
    return [
        f"{log}half of what is left lies within {' and '.join(f'{first:.4g} to {last:.4g} s' for first, last in parts)}"
        ": if something touched the robot or a joint met its stop there, take these samples out of the log and "
        "diagnose again, as they spoil all sizes"
        for log, parts in found.items()
        if parts
    ]


def spans(data: FitData, fit: CandidateFit) -> list[tuple[float, float]]:
    """Return the few short parts of a log that hold half of what a fit leaves above the floor; none where it is spread.

    Args:
        data: The log.
        fit: The fit.

    Returns:
        Beginnings and ends since the beginning of the log [s].
    """
    record = data.record
    n, M = record.position.shape
    squares = fit.residual(data.without_torques)[: M * n].reshape(M, n) ** 2
    excess = np.sum(squares - np.isfinite(data.spread).T, axis=0)
    if not np.all(np.isfinite(excess)) or excess.sum() < (LEAST - 1.0) * data.n_values:
        return []
    length = max(1, round(WINDOW / record.sample_time))
    begins = np.arange(0, n, length)
    sums = np.add.reduceat(excess, begins)
    order = np.argsort(-sums)
    number = 1 + int(np.argmax(np.cumsum(sums[order]) >= HELD * excess.sum()))
    places = np.sort(order[:number])
    runs = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)
    if number > SHORT * len(begins) or len(runs) > FEW:
        return []
    T = record.sample_time
    return [(record.begin + begins[run[0]] * T, record.begin + min(begins[run[-1]] + length, n) * T) for run in runs]
