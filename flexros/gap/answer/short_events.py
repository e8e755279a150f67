"""Short parts of a log that hold much of what an answer leaves: a push, a collision, a stop, a resonance in a sweep."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import detrend

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.answer.decision import Findings
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.schema import GapNumbers

WINDOW = 0.25
"""Length of the parts that are looked at [s] (chosen)."""
HELD, SHORT, FEW = 0.5, 0.06, 3
"""Share of what is left above the floor that a few parts hold, share of the log that they are at most, and their number
[1] (chosen): friction leaves something at every reversal."""
LEAST = 2.0
"""Mean squared prediction error over its floor from which it is looked for [1] (chosen)."""
NARROW, PERIODS, FINER = 0.5, 4.0, 16
"""Share of the power that a line holds, its least number of periods, and how much finer than its resolution its
frequency is looked for [1] (chosen)."""
SLOWER = 2.0
"""Commands that are slower than a line by more than this have nothing to do with it [1] (chosen): slews of a sweep."""


def short_events(findings: Findings, gap: GapNumbers) -> list[str]:
    """Say when most of what is left happened, where that is short: it spoils the sizes of all effects.

    A sweep that passes a resonance is told as such: there alone it shows. Nothing is said of a gap within its floor.
    """
    left = gap.before if gap.after is None else gap.after
    if left <= findings.settings.floors * (gap.tolerance_floor or gap.noise_floor):
        return []
    logs = {
        "": (findings.data, findings.explanations.chosen),
        "held-out log: ": (findings.held, findings.held_chosen),
    }
    return [f"{log}{text}" for log, one in logs.items() for text in _told(*one)]


def _told(data: FitData, fit: CandidateFit) -> list[str]:
    """Say what the short parts of a log are."""
    parts = spans(data, fit)
    within = " and ".join(f"{round(first, 2):.10g} to {round(last, 2):.10g} s" for first, last in parts)
    passed = [resonance(data, fit, part) for part in parts]
    sizes = " and ".join(f"{frequency:.3g} Hz" for frequency in passed if frequency is not None)
    if not parts:
        return []
    if all(passed):
        return [
            f"half of what is left lies within {within}: the motion passes a resonance at about {sizes} there, which "
            "the model has not or elsewhere. Keep these samples, as no other part of the log shows it"
        ]
    besides = f" (but not where the motion passes a resonance at about {sizes})" if sizes else ""
    return [
        f"half of what is left lies within {within}: if something touched the robot or a joint met its stop there, "
        f"take these samples out of the log{besides} and diagnose again, as they spoil all sizes"
    ]


def spans(data: FitData, fit: CandidateFit) -> list[tuple[float, float]]:
    """Return the few short parts of a log that hold half of what a fit leaves above the floor; none where it is spread.

    None either where the end of the log is among them, at which there is nothing to take out. What an error of the
    initial state leaves is no event.

    Args:
        data: The log.
        fit: The fit.

    Returns:
        Beginnings and ends since the beginning of the log [s].
    """
    record = data.record
    n = record.n_samples
    excess = np.sum(_left(data, fit) ** 2 - np.isfinite(data.spread).T, axis=0) * data.settled
    if not np.all(np.isfinite(excess)) or excess.sum() < (LEAST - 1.0) * data.n_values:
        return []
    length = max(1, round(WINDOW / record.sample_time))
    begins = np.arange(0, max(n - length, 0) + 1, length)  # the last part takes the rest
    sums = np.add.reduceat(excess, begins)
    order = np.argsort(-sums)
    number = 1 + int(np.argmax(np.cumsum(sums[order]) >= HELD * excess.sum()))
    places = np.sort(order[:number])
    runs = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)
    if number > SHORT * len(begins) or len(runs) > FEW or places[-1] == len(begins) - 1:
        return []
    T = record.sample_time
    return [(record.begin + begins[run[0]] * T, record.begin + begins[run[-1] + 1] * T) for run in runs]


def resonance(data: FitData, fit: CandidateFit, part: tuple[float, float]) -> float | None:
    """Return the frequency of a resonance that a sweep passes in a part of a log [Hz]; None where none does.

    What is left there is a narrow line at the frequency of the commands, which is lower before and higher behind, or
    the other way round. Where something touched a robot that then rings, its commands had no such line before.

    Args:
        data: The log.
        fit: The fit.
        part: Begin and end of the part since the beginning of the log [s].
    """
    record, T = data.record, data.record.sample_time
    begin, end = (round((time - record.begin) / T) for time in part)
    length = end - begin
    left = np.where(np.isfinite(data.spread).T, _left(data, fit), 0.0)
    motor = int(np.argmax(np.sum(left[:, begin:end] ** 2, axis=1)))
    at = line(left[motor, begin:end], T)
    if at is None or begin < length or end + length > record.n_samples:
        return None
    commands = record.driving[:, motor]
    sweep = [line(commands[k : k + length], T, at / SLOWER) for k in (begin - length, begin, end)]
    before, there, behind = (np.nan if frequency is None else frequency for frequency in sweep)
    passes = before < there < behind or before > there > behind
    return at if passes and abs(at - there) <= max(1.0 / (length * T), abs(behind - before) / 2) else None


def line(values: FloatArray, sample_time: float, lowest: float = 0.0) -> float | None:
    """Return the frequency of a narrow line that a signal is [Hz]; None for any other signal.

    Args:
        values: The signal, shape (n,).
        sample_time: Time between two samples [s].
        lowest: Frequency below which the signal does not count [Hz].
    """
    n = len(values)
    power = np.abs(np.fft.rfft(detrend(values) * np.hanning(n), FINER * n)) ** 2
    frequency = np.fft.rfftfreq(FINER * n, sample_time)
    power[frequency < lowest] = 0.0
    at = frequency[np.argmax(power)]
    near = np.abs(frequency - at) <= 2.0 / (n * sample_time)  # half of the main lobe of the window
    narrow = power[near].sum() > NARROW * power.sum() and at * n * sample_time >= PERIODS
    return float(at) if narrow else None


def _left(data: FitData, fit: CandidateFit) -> FloatArray:
    """Return what a fit leaves of the positions of the motors over its floor [1], shape (M, n)."""
    n, M = data.record.position.shape
    return np.asarray(fit.residual(data.without_torques)[: M * n].reshape(M, n))
