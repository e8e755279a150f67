"""Scores of crowds as tables, for the terminal and for pages."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.table import Table

from flexros.validation.blind.score.crowds import claimed, crowd_score, crowds_of, found, has_outside

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.blind.score.crowds import CrowdScore
    from flexros.validation.blind.score.statistics import Share

ROWS = (
    ("effects named at their location (recall)", "recall"),
    ("the same, nested effects counted", "recall_nested"),
    ("named, or called ambiguous with what is named", "recall_grouped"),
    ("named causes that are hidden there (precision)", "precision"),
    ("the same, nested effects counted", "precision_nested"),
    ("hidden there, or called ambiguous with what is", "precision_grouped"),
    ("whole crowd named and nothing else", "whole"),
    ("the same, nested effects counted", "whole_nested"),
    ("named at the right location, of those with a right name", "location"),
    ("sizes in their 95 % intervals", "covered"),
    ("`explained` although more than the floor is left", "over_claims"),
    ("the same, and more than twice what the true effects leave", "over_truth"),
    ("`explained` although something is missing", "incomplete"),
    ("patch closes 97 % of what the true effects close of a third log", "third_97"),
    ("refused", "refused"),
)
"""Shares by description."""
NUMBERS = (
    ("median closed fraction of third logs", "closed_third"),
    ("the same with the true effects", "closed_truth"),
    ("median error of the shares added first", "first_off"),
    ("median error of the shares removed last", "last_off"),
    ("median time of a diagnosis [s]", "seconds"),
    ("crowds", "cases"),
)
"""Other figures by description."""


def crowd_groups(answers: Sequence[Answer]) -> dict[str, list[Answer]]:
    """Divide crowds: of the library alone by state of the nominal model, and those with a cause outside it.

    Args:
        answers: The cases; others than crowds are skipped.
    """
    crowds = crowds_of(answers)
    rules: dict[str, Callable[[Answer], bool]] = {
        "nominal exact": lambda one: one.truth.nuisance == "exact" and not has_outside(one),
        "nominal 3 % off": lambda one: one.truth.nuisance != "exact" and not has_outside(one),
        "one cause outside the library": has_outside,
    }
    return {name: [one for one in crowds if rule(one)] for name, rule in rules.items()}


def crowd_rows(scores: Mapping[str, CrowdScore]) -> list[list[str]]:
    """List the rows of a table of scores of crowds.

    Args:
        scores: Scores by the heading of their column.

    Returns:
        Rows: what it is, then one text per column.
    """
    columns = list(scores.values())
    rows = [[name, *[_share(getattr(one, key)) for one in columns]] for name, key in ROWS]
    sizes = columns[0].by_size if columns else {}
    rows += [[f"named, gain {size} nats", *[_share(one.by_size[size]) for one in columns]] for size in sizes]
    rows += [[name, *[_number(getattr(one, key)) for one in columns]] for name, key in NUMBERS]
    return [row for row in rows if any(row[1:])]


def crowd_table(answers: Sequence[Answer]) -> Table:
    """Lay out the figures of the crowds.

    Args:
        answers: The cases.
    """
    by = {name: crowd_score(some) for name, some in crowd_groups(answers).items() if some}
    table = Table("", *by, title=f"{len(crowds_of(answers))} crowds of effects")
    for row in crowd_rows(by):
        table.add_row(*row)
    return table


def case_lines(answers: Sequence[Answer]) -> list[list[str]]:
    """List the crowds one by one.

    Args:
        answers: The cases; others than crowds are skipped.

    Returns:
        Of each: name, robot, nominal model, verdict, what was found, what is missing, and what was named wrongly.
    """
    rows = []
    for one in crowds_of(answers):
        hidden = list(zip(one.truth.deviations, one.truth.gains, strict=True))
        got = [f"{what.place} {gain:.3g}" for what, gain in hidden if found(one, what, nested=True)]
        missing = [f"{what.place} {gain:.3g}" for what, gain in hidden if not found(one, what, nested=True)]
        wrong = [f"{c.effect}@{c.location}" for c in claimed(one) if not one.right(c, nested=True, placed=True)]
        verdict = "refused" if one.diagnosis is None else one.diagnosis.verdict
        lists = ("; ".join(some) for some in (got, missing, wrong))
        rows.append([one.truth.name, one.truth.robot, one.truth.nuisance, verdict, *lists])
    return rows


def _share(value: Share) -> str:
    return str(value) if value.cases else ""


def _number(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else ""
