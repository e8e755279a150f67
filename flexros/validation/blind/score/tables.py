"""Scores of a blind check as tables, for the terminal and for pages."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.table import Table

from flexros.validation.blind.score.score import confusion, score, scores_by

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.blind.score.score import Score
    from flexros.validation.blind.score.statistics import Share

ROWS = (
    ("right effect first (top-1)", "top_1"),
    ("the same, nested effects counted", "top_1_nested"),
    ("right effect among first three", "top_3"),
    ("right effect in the ambiguity group", "in_group"),
    ("right location, of those with right name", "location"),
    ("gap detected", "detected"),
    ("false alarms of logs without deviation", "false_alarms"),
    ("cause outside the library reported as unknown", "unknown_found"),
    ("cause outside the library detected", "unknown_seen"),
    ("effect of the library reported as unknown", "known_unknown"),
    ("both effects of a pair first", "pairs"),
    ("the same, nested effects counted", "pairs_nested"),
    ("size in its 95 % interval", "covered"),
    ("patch closes 95 % of the gap of a third log", "third_95"),
    ("logs refused", "refused"),
)
"""Shares by description; of visible deviations unless stated otherwise."""


WIDE = 150
"""Width of a terminal from which the states of the nominal model have columns of their own [characters]."""


def score_table(answers: Sequence[Answer], width: int = WIDE) -> Table:
    """Lay out the figures of all cases, and where the width allows of exact and wrong nominal models.

    Args:
        answers: The cases.
        width: Width of the terminal [characters].

    Returns:
        The table.
    """
    by = {"all": score(answers), **(scores_by(answers, "nuisance") if width >= WIDE else {})}
    table = Table("", title=f"Blind check of {len(answers)} logs")
    table.columns[0].no_wrap = True
    for name in by:
        table.add_column(name)
    for row in figure_rows(by):
        table.add_row(*row)
    return table


def figure_rows(scores: dict[str, Score]) -> list[list[str]]:
    """List the rows of a table of scores.

    Args:
        scores: Scores by the heading of their column.

    Returns:
        Rows: what it is, then one text per column.
    """
    columns = list(scores.values())
    rows = [[name, *[_share(getattr(one, key)) for one in columns]] for name, key in ROWS]
    rows.append(["mean size of ambiguity groups", *[_number(one.group_size) for one in columns]])
    rows.append(["calibration error of the first cause", *[_calibration(one, "error") for one in columns]])
    rows.append(["log loss of the first cause [nats]", *[_calibration(one, "log_loss") for one in columns]])
    rows.append(["gain at which 50 % are detected [nats]", *[_number(one.detection.centre) for one in columns]])
    rows.append(["gain at which 90 % are detected [nats]", *[_number(one.detection.at_90) for one in columns]])
    rows.append(["gain at which 50 % are named [nats]", *[_number(one.naming.centre) for one in columns]])
    rows.append(["gain at which 90 % are named [nats]", *[_number(one.naming.at_90) for one in columns]])
    rows.append(["median closed fraction", *[_number(one.closed) for one in columns]])
    rows.append(["median closed fraction over the oracle's", *[_number(one.closed_oracle) for one in columns]])
    rows.append(["median closed fraction of the best impostor", *[_number(one.closed_rival) for one in columns]])
    rows.append(["median closed fraction less the impostor's", *[_number(one.margin) for one in columns]])
    rows.append(["median closed fraction of third logs", *[_number(one.closed_third) for one in columns]])
    rows.append(["median time of a diagnosis [s]", *[_number(one.seconds) for one in columns]])
    rows.append(["logs", *[str(one.cases) for one in columns]])
    return [row for row in rows if any(text for text in row[1:])]


def wrong_table(answers: Sequence[Answer]) -> Table:
    """List the reported answers for visible single effects, logs without deviation and causes outside the library.

    Args:
        answers: The cases.

    Returns:
        The table: the confusion matrix without its empty entries.
    """
    table = Table("truth", "logs", "reported", title="Reported answers for each truth")
    for truth, counts in confusion(answers).items():
        reported = ", ".join(f"{name} {number}" for name, number in counts.most_common())
        table.add_row(truth, str(sum(counts.values())), reported)
    return table


def _share(value: Share) -> str:
    return str(value) if value.cases else ""


def _number(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else ""


def _calibration(one: Score, key: str) -> str:
    return "" if one.calibration is None else _number(getattr(one.calibration, key))
