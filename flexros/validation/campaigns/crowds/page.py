"""Page of results of the crowds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.blind.score.crowd_tables import case_lines, crowd_groups, crowd_rows
from flexros.validation.blind.score.crowds import CLAIMED, OVER, crowd_score, crowd_sizes
from flexros.validation.campaigns.markdown import logs_without_answer, table, version_line

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.campaigns.crowds.settings import CrowdSettings

GOALS: Mapping[str, tuple[str, str, str]] = {
    "effects named at their location (recall)": ("95 %", "88 %", ""),
    "named causes that are hidden there (precision)": ("97 %", "95 %", ""),
    "sizes in their 95 % intervals": ("90 %", "", ""),
    "`explained` although more than the floor is left": ("at most 1 %", "at most 1 %", "at most 1 %"),
}
"""Goals by row, for each column of the table."""


def crowds_page(
    answers: Sequence[Answer],
    failures: Mapping[str, str],
    planned: int,
    settings: CrowdSettings,
    used: Mapping[str, str],
) -> str:
    """Write the page.

    Args:
        answers: The cases as scored.
        failures: What stopped a diagnosis, by name of the case.
        planned: Number of cases of the whole plan.
        settings: Settings of the campaign.
        used: Versions by package.

    Returns:
        Markdown.
    """
    undrawn = sorted(failures.keys() - {one.truth.name for one in answers})
    cases = f"the first {len(answers) + len(undrawn)} of {planned} planned cases"
    if undrawn:
        cases += f" ({', '.join(undrawn)} could not be drawn)"
    lines = ["# Blind crowds", "", *_introduction(answers, cases, settings), ""]
    lines += _scores(crowd_groups(answers))
    lines += ["", "## By robot", "", *_scores(_by_robot(answers), goals=False)]
    lines += ["", "## Case by case", "", "Behind each hidden effect is its gain when it is added last [nats].", ""]
    headings = ("case", "robot", "nominal model", "verdict", "named", "missing", "named wrongly")
    lines += table(headings, case_lines(answers))
    lines += ["", "## Sizes outside their 95 % intervals", "", *_sizes(answers)]
    lines += [*logs_without_answer(failures), "", f"{version_line(used)}."]
    return "\n".join(lines) + "\n"


def crowds_summary(answers: Sequence[Answer], planned: int) -> tuple[str, ...]:
    """Return the result in sentences.

    Args:
        answers: The cases as scored.
        planned: Number of cases of the whole plan.
    """
    sentences = [f"{len(answers)} of {planned} planned crowds."]
    for name, some in crowd_groups(answers).items():
        if some:
            one = crowd_score(some)
            sentences.append(f"{name}: recall {one.recall}; precision {one.precision}; whole crowd {one.whole}.")
    return tuple(sentences)


def _introduction(answers: Sequence[Answer], cases: str, settings: CrowdSettings) -> list[str]:
    few = " These are few cases: read the intervals, not the shares." if len(answers) < 40 else ""
    return [
        f"Written by `flexros campaign crowds`: {cases}, seed {settings.seed} of the evaluation stream, which was not "
        f"used in development.{few} Every case is a robot with "
        "3 to 12 hidden effects at 1 to 6 motors, other joints clean, half of them plain friction, simulated with "
        "other equations, laws and time steps than those of the diagnosis. The diagnosis gets a log of "
        f"{settings.durations[0]:g} s, a second one of {settings.durations[1]:g} s and the nominal model; a third one "
        f"of {settings.durations[2]:g} s tests its patch. Shares have 95 % intervals (Wilson), as if the effects of a "
        "crowd were independent.",
        "",
        "Every hidden effect is worth at least 50 nats of expected log-likelihood when it is added last: with all "
        "others present, less what their sizes and the tolerated numbers of the nominal model could take over. That is "
        "by one filter of the true robot. A diagnosis follows the encoders more loosely and sees more of it, or more "
        "closely and sees less, while its model is far off or where its filter would settle too late in the log. A "
        f"cause counts as named from a probability of {CLAIMED:g}; effect and location must be right. Nested effects, "
        "of which one contains the other as a special case, are counted separately. More than the floor is left "
        f"where the gap of the third log is above {OVER:g} floors with the patch. The true effects, for the third log "
        "and for the budget, are those of the library with the numbers of the truth on the true robot, without a "
        "refit; where their laws differ in form from those of the simulator, they leave a rest as well.",
    ]


def _scores(groups: Mapping[str, Sequence[Answer]], goals: bool = True) -> list[str]:
    scores = {name: crowd_score(some) for name, some in groups.items()}
    by = {f"{name} ({one.cases})": one for name, one in scores.items()}
    rows = [list(row) for row in crowd_rows(by)]
    for row in rows if goals else ():
        for column, goal in enumerate(GOALS.get(row[0], ()), start=1):
            row[column] += f" (goal {goal})" if goal and row[column] else ""
    return table(["", *by], rows)


def _by_robot(answers: Sequence[Answer]) -> dict[str, list[Answer]]:
    names = sorted({one.truth.robot for one in answers})
    return {name: [one for one in answers if one.truth.robot == name] for name in names}


def _sizes(answers: Sequence[Answer]) -> list[str]:
    headings = ("case", "robot", "effect", "size", "true", "fitted", "standard deviations off")
    rows = []
    for one in crowd_sizes(answers):
        if not one.covered:
            off = abs(one.fitted.value - one.true) / one.fitted.std if one.fitted.std > 0 else np.inf
            numbers = f"{one.true:.5g}", f"{one.fitted.value:.5g} {one.fitted.unit}".rstrip(), f"{off:.1f}"
            rows.append((one.answer.truth.name, one.answer.truth.robot, one.hidden.place, one.name, *numbers))
    return table(headings, rows)
