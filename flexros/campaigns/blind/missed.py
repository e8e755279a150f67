"""What a blind check missed, case by case: causes, and sizes outside their intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.blind.coverage import fitted_sizes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.blind.answer import Answer

LISTED = 3
"""Causes that are listed of an answer."""


def missed_cases(answers: Sequence[Answer]) -> list[str]:
    """List what was missed: false alarms, causes that were not named, and known ones where the cause is unknown.

    Args:
        answers: The cases as scored.

    Returns:
        Lines of a table in Markdown, one row per case.
    """
    lines = ["| case | robot | nominal model | motion | hidden, gain in nats | said, probability | |", "|---" * 7 + "|"]
    return [*lines, *(_row(one) for one in answers if one.missed)]


def missed_sizes(answers: Sequence[Answer]) -> list[str]:
    """List the fitted sizes whose 95 % interval does not cover the truth.

    Args:
        answers: The cases as scored.

    Returns:
        Lines of a table in Markdown, one row per case.
    """
    lines = ["| case | robot | effect | size | true | fitted | standard deviations off |", "|---" * 7 + "|"]
    for one in fitted_sizes(answers):
        if not one.covered:
            truth, fitted = one.answer.truth, one.fitted
            off = abs(fitted.value - one.true) / fitted.std if fitted.std > 0 else float("inf")
            sizes = f"{one.true:.5g} | {fitted.value:.5g} {fitted.unit}".rstrip()
            lines.append(
                f"| {truth.name} | {truth.robot} | {truth.deviations[0].effect} | {one.name} | {sizes} | {off:.1f} |"
            )
    return lines


def _row(one: Answer) -> str:
    truth = one.truth
    hidden = [f"{what.effect} {what.location} {gain:.3g}" for what, gain in zip(truth.deviations, truth.gains)]
    causes = [f"{cause.effect} {cause.location} {cause.probability:.2f}" for cause in one.causes[:LISTED]]
    cells = [
        truth.name,
        truth.robot,
        truth.nuisance,
        f"{truth.motion}, {1e3 * truth.sample_time:g} ms",
        "; ".join(hidden) or "nothing",
        "; ".join(causes) or one.said,
        one.missed,
    ]
    return f"| {' | '.join(cells)} |"
