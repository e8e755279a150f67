"""The answer of a diagnosis for a terminal, in the words of the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.report.verdict import verdict_sentence
from flexros.gap.report.words import (
    budget_words,
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

_RANKED, _LOCATIONS = 6, 3
"""Number of effects and locations that are printed (chosen)."""


def verdict_line(diagnosis: Diagnosis) -> str:
    """Return the verdict: its word and its sentence."""
    return f"{diagnosis.verdict}: {verdict_sentence(diagnosis)}"


def ranking_table(result: DiagnosisResult) -> Table:
    """Return a table of the first effects by probability, and of 'nothing'."""
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("effect", min_width=20)
    for heading in ("probability", "gain", "leaves"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("fitted", min_width=22)
    for candidate in result.ranking[:_RANKED]:
        left = "-" if candidate.remainder is None else share_words(candidate.remainder)
        cells = (capital(named(candidate)), share_words(candidate.probability), number(candidate.score, 4), left)
        table.add_row(*map(Text, (*cells, clear_words(candidate.parameters))))
    table.add_row("Nothing", share_words(result.null_probability), "0", "100 %", "")
    return table


def where_lines(result: DiagnosisResult) -> tuple[str, ...]:
    """Describe the first locations of the gap."""
    return tuple(
        f"{where_words(location, result.record.sample_time)}, {p_value_words(location.p_value)}"
        for location in result.diagnosis.where[:_LOCATIONS]
    )


def budget_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """List the shares of the gap by effect, and what is left by joint; nothing for a single effect."""
    effects = [share for share in diagnosis.budget if share.effect is not None]
    if len(effects) < 2 and not (effects and diagnosis.verdict == "partly_explained"):
        return ()
    shares = [
        f"{capital(budget_words(share))}: {share_words(max(share.share_last or 0.0, 0.0))} removed last, "
        f"{share_words(max(share.share_first or 0.0, 0.0))} added first"
        for share in effects
    ]
    left = [
        f"left at {rest.joint}: {share_words(rest.share)}" for rest in diagnosis.unexplained if rest.regime == "all"
    ]
    return (*shares, *left)


def gap_line(gap: GapNumbers) -> str:
    """Return the gap in one line."""
    unit = "" if gap.unit in ("", "1") else f" {gap.unit}"
    parts = [f"{number(gap.before, 4)}{unit} before", f"floor {number(gap.noise_floor, 4)}"]
    if gap.after is not None:
        parts.insert(1, f"{number(gap.after, 4)} after")
    if gap.best_rival is not None:
        parts.append(f"best rival {number(gap.best_rival, 4)}")
    if gap.closed_fraction is not None and shows(gap):
        parts.append(f"{closed_words(gap.closed_fraction)} closed{interval_words(gap.interval)}")
    return f"Gap ({gap.metric}): {', '.join(parts)}"


def group_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """List the groups of effects that the log cannot distinguish."""
    return tuple(
        f"Not distinguishable: {first_few([named(location) for location in group], most=6)}"
        for group in diagnosis.ambiguity_groups
    )


def next_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return the experiment to run next, and its command."""
    experiment = diagnosis.next_experiment
    if experiment is None:
        return ()
    line = f"Next experiment: {experiment.name}, {experiment.description.rstrip('.')}"
    return (line, f"  {experiment.command}") if experiment.command else (line,)
