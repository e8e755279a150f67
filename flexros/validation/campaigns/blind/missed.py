"""Misses of a blind check, case by case: causes, and sizes outside their intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.validation.blind.score.coverage import fitted_sizes
from flexros.validation.campaigns.markdown import table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.blind.score.coverage import FittedSize

LISTED = 3
"""Causes that are listed of an answer."""


def missed_cases(answers: Sequence[Answer]) -> list[str]:
    """List what was missed: false alarms, causes that were not named, and known ones where the cause is unknown.

    Args:
        answers: The cases as scored.

    Returns:
        Lines of a table in Markdown, one row per case.
    """
    headings = ("case", "robot", "nominal model", "motion", "hidden, gain in nats", "reported, probability", "")
    return table(headings, [_case(one) for one in answers if one.missed])


def missed_sizes(answers: Sequence[Answer]) -> list[str]:
    """List the fitted sizes whose 95 % interval does not cover the truth.

    Args:
        answers: The cases as scored.

    Returns:
        Lines of a table in Markdown, one row per case.
    """
    headings = ("case", "robot", "effect", "size", "true", "fitted", "standard deviations off")
    return table(headings, [_size(one) for one in fitted_sizes(answers) if not one.covered])


def _size(one: FittedSize) -> tuple[str, ...]:
    truth, fitted = one.answer.truth, one.fitted
    off = abs(fitted.value - one.true) / fitted.std if fitted.std > 0 else float("inf")
    sizes = f"{one.true:.5g}", f"{fitted.value:.5g} {fitted.unit}".rstrip()
    return truth.name, truth.robot, one.hidden.effect, one.name, *sizes, f"{off:.1f}"


def _case(one: Answer) -> tuple[str, ...]:
    truth = one.truth
    hidden = [f"{what.effect} {what.location} {gain:.3g}" for what, gain in zip(truth.deviations, truth.gains)]
    causes = [f"{cause.effect} {cause.location} {cause.probability:.2f}" for cause in one.causes[:LISTED]]
    return (
        truth.name,
        truth.robot,
        truth.nuisance,
        f"{truth.motion}, {1e3 * truth.sample_time:g} ms",
        "; ".join(hidden) or "nothing",
        "; ".join(causes) or one.reported,
        one.missed,
    )
