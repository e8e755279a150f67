"""The answer of a diagnosis for a terminal: the same words and figures as in the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.report.verdict import verdict_sentence
from flexros.gap.report.words import (
    capital,
    clear_words,
    closed_words,
    first_few,
    interval_words,
    named,
    p_value_words,
    share_words,
    shows,
    where_words,
)
from flexros.report.number_text import number

if TYPE_CHECKING:
    from rich.table import Table

    from flexros.gap.result import DiagnosisResult
    from flexros.gap.schema import Diagnosis, GapNumbers

_RANKED, _PLACES = 6, 3
"""Effects and places that are printed (chosen)."""


def verdict_line(diagnosis: Diagnosis) -> str:
    """Write the verdict: its word and its sentence.

    Args:
        diagnosis: The answer.
    """
    return f"{diagnosis.verdict}: {verdict_sentence(diagnosis)}"


def ranking_table(result: DiagnosisResult) -> Table:
    """Lay out the first effects by probability, and 'nothing'.

    Args:
        result: What was found.
    """
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("effect", min_width=20)
    for heading in ("probability", "gain", "leaves"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("fitted", min_width=22)
    for one in result.ranking[:_RANKED]:
        left = "-" if one.remainder is None else share_words(one.remainder)
        cells = (capital(named(one)), share_words(one.probability), number(one.score, 4), left)
        table.add_row(*map(Text, (*cells, clear_words(one.parameters))))
    table.add_row("Nothing", share_words(result.null_probability), "0", "100 %", "")
    return table


def where_lines(result: DiagnosisResult) -> tuple[str, ...]:
    """Write the first places where the gap shows.

    Args:
        result: What was found.
    """
    return tuple(
        f"{where_words(place, result.record.sample_time)}, {p_value_words(place.p_value)}"
        for place in result.diagnosis.where[:_PLACES]
    )


def gap_line(gap: GapNumbers) -> str:
    """Write the gap numbers in a line.

    Args:
        gap: The numbers.
    """
    unit = "" if gap.unit in ("", "1") else f" {gap.unit}"
    told = [f"{number(gap.before, 4)}{unit} before", f"floor {number(gap.noise_floor, 4)}"]
    if gap.after is not None:
        told.insert(1, f"{number(gap.after, 4)} after")
    if gap.best_rival is not None:
        told.append(f"best rival {number(gap.best_rival, 4)}")
    if gap.closed_fraction is not None and shows(gap):
        told.append(f"{closed_words(gap.closed_fraction)} closed{interval_words(gap.interval)}")
    return f"Gap ({gap.metric}): {', '.join(told)}"


def group_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Write the groups of effects that the log cannot tell apart.

    Args:
        diagnosis: The answer.
    """
    return tuple(
        f"Not told apart: {first_few([named(place) for place in group], most=6)}"
        for group in diagnosis.ambiguity_groups
    )


def next_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Write the experiment to run next, and its command.

    Args:
        diagnosis: The answer.
    """
    following = diagnosis.next_experiment
    if following is None:
        return ()
    line = f"Next experiment: {following.name}, {following.description.rstrip('.')}"
    return (line, f"  {following.command}") if following.command else (line,)
