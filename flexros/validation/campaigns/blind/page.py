"""Page of results of the blind check."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.blind.score.answer import VISIBLE
from flexros.validation.blind.score.score import record, score, scores_by
from flexros.validation.blind.score.tables import figure_rows
from flexros.validation.campaigns.blind.missed import missed_cases, missed_sizes
from flexros.validation.campaigns.markdown import logs_without_answer, version_line

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.blind.score.score import Score
    from flexros.validation.campaigns.blind.settings import BlindSettings

GROUPS = {
    "By state of the nominal model": "nuisance",
    "By robot": "robot",
    "By size": "size",
    "By motion": "motion",
    "With and without measured tool": "tool",
    "By sample time [s]": "sample_time",
}
"""Headings, and the keys of the truth by which the scores below are grouped."""

PICTURES = {
    "confusion": "Confusion matrix of single effects well above the noise, logs without deviation, and causes outside "
    "the library: rows are truths, columns answers, entries numbers of logs.",
    "detection": "Share of single effects that are detected and named against their expected gain in log-likelihood.",
    "calibration": "Calibration of the first cause.",
}


def blind_page(
    answers: Sequence[Answer],
    failures: Mapping[str, str],
    planned: int,
    settings: BlindSettings,
    drawn: Mapping[str, str],
    used: Mapping[str, str],
) -> str:
    """Write the page.

    Args:
        answers: The cases as scored.
        failures: What stopped a diagnosis, by name of the case.
        planned: Number of cases of the whole plan.
        settings: Settings of the campaign.
        drawn: Pictures by name.
        used: Versions by package.

    Returns:
        Markdown.
    """
    lines = ["# Blind check of the diagnosis", "", *_introduction(answers, planned, settings), ""]
    lines += _table({"all": score(answers)})
    for name, text in PICTURES.items():
        if name in drawn:
            lines += ["", f"![{name}](figures/blind_{name}.svg)", "", text]
    for heading, key in GROUPS.items():
        lines += ["", f"## {heading}", "", *_table(scores_by(answers, key))]
    lines += ["", "## By effect", "", *_effects(answers)]
    lines += ["", "## Missed cases", "", *missed_cases(answers)]
    lines += ["", "## Sizes outside their 95 % intervals", "", *missed_sizes(answers)]
    lines += [*logs_without_answer(failures), "", f"{version_line(used)}."]
    return "\n".join(lines) + "\n"


def _introduction(answers: Sequence[Answer], planned: int, settings: BlindSettings) -> list[str]:
    return [
        f"Written by `flexros campaign blind`: {len(answers)} of {planned} planned cases, seed {settings.seed} of the "
        "evaluation stream, which was not used in development. Every case is a robot with a hidden deviation, "
        "simulated with other equations, laws and time steps than those of the diagnosis. The diagnosis gets a log of "
        f"{settings.durations[0]:g} s, a second one of {settings.durations[1]:g} s and the nominal model. Its patch is "
        f"then compared with a third log of {settings.durations[2]:g} s that it did not get. The truth was sealed "
        "before. Shares have 95 % intervals (Wilson). Effects are well above the noise when the expected gain in "
        f"log-likelihood of the true model is at least {VISIBLE:g}; shares of effects refer to those, detection curves "
        "to all. Nested effects, of which one contains the other as a special case, are counted separately.",
    ]


def _table(scores: dict[str, Score]) -> list[str]:
    lines = ["| | " + " | ".join(scores) + " |", "|---" * (len(scores) + 1) + "|"]
    return [*lines, *["| " + " | ".join(row) + " |" for row in figure_rows(scores)]]


def _effects(answers: Sequence[Answer]) -> list[str]:
    lines = [
        "| effect | well above the noise | first | first, nested counted | among three | detected | named at 90 % "
        "[nats] | size in its 95 % interval |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, one in record(answers)["effects"].items():
        shares = [_percent(one[key]) for key in ("top_1", "top_1_nested", "top_3", "detected")]
        half = one["naming"]["at_90"]
        bound = f"{half:.3g}" if np.isfinite(half) else ""
        sizes = f"{one['covered']['hits']} of {one['covered']['cases']}" if one["covered"]["cases"] else ""
        lines.append(f"| {name} | {one['top_1']['cases']} | {' | '.join(shares)} | {bound} | {sizes} |")
    return lines


def _percent(share: Mapping[str, int]) -> str:
    return f"{100 * share['hits'] / share['cases']:.0f} %" if share["cases"] else ""


def blind_summary(answers: Sequence[Answer], planned: int) -> tuple[str, ...]:
    """Return the result in sentences.

    Args:
        answers: The cases as scored.
        planned: Number of cases of the whole plan.
    """
    found = score(answers)
    rest = planned - len(answers)
    sentences = [
        f"{len(answers)} of {planned} planned cases; right effect first in {found.top_1} "
        f"(with nested effects {found.top_1_nested}).",
        f"False alarms in {found.false_alarms}; unknown causes reported as unknown in {found.unknown_found}; known "
        f"ones in {found.known_unknown}; both of a pair in {found.pairs_nested}.",
    ]
    if rest and np.isfinite(found.seconds):
        hours = rest * found.seconds / 3600
        sentences.append(
            f"The other {rest} cases take about {hours:.1f} h on one worker of this speed; continue with more "
            "repetitions."
        )
    return tuple(sentences)
