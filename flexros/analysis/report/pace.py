"""Texts and tables of the pace of a loop in real time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.report.base import Block, TextTable
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.pace import Pacing
    from flexros.analysis.run_analysis import Analysis


_BURSTS = 0.9
"""Messages whose median period is below this share of the mean arrive in bursts (chosen)."""


def pace_sentence(analysis: Analysis, named: bool) -> str:
    """Describe the pace of a run in real time.

    Args:
        analysis: The run.
        named: Whether to begin with its label.

    Returns:
        Sentences.
    """
    timing = analysis.timing
    begin = f"{analysis.label} ran" if named else "The loop ran"
    text = f"{begin} in real time, paced by the wall clock: {_schedule(timing.pacing)}."
    states = timing.arrival("joint_states")
    if states is None:
        return f"{text} The log times are the stamps, so the receive times are not known."
    if states.period_median < _BURSTS * states.mean_period:
        return (
            f"{text} The recorder received joint_states in bursts, after waits of up to "
            f"{number(1e3 * states.period_max)} ms, so its times describe the recorder rather than the loop."
        )
    return (
        f"{text} The recorder received joint_states every {number(1e3 * states.period_median)} ms (median); 99 % of "
        f"the periods were below {number(1e3 * states.period_p99)} ms, the longest was "
        f"{number(1e3 * states.period_max)} ms."
    )


def _schedule(pacing: Pacing | None) -> str:
    if pacing is None:
        return "the log does not contain the plant's report of it"
    return ", and ".join(filter(None, (_late(pacing), missed_text(pacing)))) or "the plant did not report how well"


def _late(pacing: Pacing) -> str:
    if pacing.late_share is None:
        return ""
    cycles = "its cycles" if pacing.cycles is None else f"{pacing.cycles} cycles"
    text = f"{number(1e2 * pacing.late_share, 3)} % of {cycles} began more than a tenth of the sample time late"
    return text if pacing.lateness_max is None else f"{text} (at most {number(1e3 * pacing.lateness_max, 3)} ms)"


def missed_text(pacing: Pacing) -> str:
    """Describe how many commands came too late; empty where the plant did not report it."""
    if pacing.missed_commands is None:
        return ""
    if pacing.missed_commands == 0:
        return "no command was missed"
    many = pacing.missed_commands > 1
    return f"{pacing.missed_commands} command{'s were' if many else ' was'} missed, for which the last one was held"


def pace_tables(analyses: Sequence[Analysis]) -> list[Block]:
    """Return the tables of receive times and of the plant's schedule, for the runs that have them."""
    several = len(analyses) > 1
    received = [
        (
            f"{analysis.label} {arrival.topic}" if several else arrival.topic,
            str(arrival.count),
            number(1e3 * arrival.mean_period),
            number(1e3 * arrival.period_median),
            number(1e3 * arrival.period_p99),
            number(1e3 * arrival.period_max),
            number(1e6 * arrival.jitter_std),
        )
        for analysis in analyses
        for arrival in analysis.timing.arrivals
    ]
    paced = [
        (analysis.label if several else "plant", analysis.timing.pacing)
        for analysis in analyses
        if analysis.timing.pacing is not None
    ]
    tables: list[Block] = []
    if received:
        header = ("Received", "messages", "mean period [ms]", "median [ms]", "99 % [ms]", "max [ms]", "jitter std [µs]")
        caption = "Time between two messages as the recorder received them, its own delays included."
        tables.append(TextTable(header, tuple(received), caption))
    if paced:
        tables.append(_schedules(paced))
    return tables


def _schedules(paced: Sequence[tuple[str, Pacing]]) -> TextTable:
    header = (
        "Schedule",
        "cycles",
        "median period [ms]",
        "99 % [ms]",
        "max [ms]",
        "late, 99 % [µs]",
        "late, max [µs]",
        "late cycles [%]",
        "missed",
    )
    rows = [
        (
            label,
            number(pacing.cycles),
            *(number(_scaled(value, 1e3)) for value in (pacing.period_median, pacing.period_p99, pacing.period_max)),
            *(number(_scaled(value, 1e6)) for value in (pacing.lateness_p99, pacing.lateness_max)),
            number(_scaled(pacing.late_share, 1e2), 3),
            number(pacing.missed_commands),
        )
        for label, pacing in paced
    ]
    caption = "Schedule of the plant, as reported on /diagnostics; missed are commands that came too late."
    return TextTable(header, tuple(rows), caption)


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value
