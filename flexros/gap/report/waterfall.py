"""The budget of the gap as a waterfall: at each joint from the nominal model over its effects to what is left."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate
from textwrap import wrap
from typing import TYPE_CHECKING

from flexros.gap.report.figure_words import MOST_SHARE, share_words, signed_share_words
from flexros.gap.report.words import capital, named_at
from flexros.report.colours import NOMINAL, REPAIRED

if TYPE_CHECKING:
    from collections.abc import Sequence

    import plotly.graph_objects as go

    from flexros.gap.schema import Diagnosis, Step, Waterfall

LEAST = 0.01
"""Share of the gap from which a joint and a step are shown by themselves [1] (chosen)."""
TOTALS = "#8b949e"
"""Colour of the gap before and of what is left."""
_ROW, _LABEL = 30, 19
"""Height of a row [px], and letters of its label in a line (chosen)."""
_BAR = 32
"""Letters of the longest bar in a terminal (chosen)."""


@dataclass(frozen=True)
class Row:
    """A row of a waterfall.

    Attributes:
        name: What it is.
        share: Share of the gap [1]; of a step, the change.
        begin: Where its bar begins [1].
        total: Whether it is the gap before or what is left, not a step.
        parts: Effects with what each changes, where the row is of several.
    """

    name: str
    share: float
    begin: float
    total: bool = False
    parts: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """The share in per cent, with its sign where it is a change."""
        if not self.total:
            return signed_share_words(self.share)
        return share_words(self.share) if self.share > MOST_SHARE else f"{round(100 * self.share)} %"


def rows_of(waterfall: Waterfall) -> tuple[Row, ...]:
    """List the rows of a joint: the gap before, the steps that show, all others together, and what is left.

    Where effects act against each other at the joint, those that only together close any of the gap are one row: the
    order in which they are added would decide by how much each opens or closes it.
    """
    rows, level = [Row("before", waterfall.before, 0.0, total=True)], waterfall.before
    for steps in _together([step for step in waterfall.steps if abs(step.share) >= LEAST]):
        share = sum(step.share for step in steps)
        if abs(share) >= LEAST:
            rows.append(_row(waterfall.joint, steps, level))
            level -= share
    others = waterfall.left - level
    if abs(others) >= LEAST / 2:
        rows.append(Row("all others", others, level))
    return (*rows, Row("left", waterfall.left, 0.0, total=True))


def _together(steps: Sequence[Step]) -> list[list[Step]]:
    """Join each step that opens the gap with those after it, up to the one with which they close some."""
    groups: list[list[Step]] = []
    for step in steps:
        if groups and sum(one.share for one in groups[-1]) < -LEAST / 2:
            groups[-1].append(step)
        else:
            groups.append([step])
    return groups


def _row(joint: str, steps: Sequence[Step], level: float) -> Row:
    """Make the row of one step, or of several by the name of the largest."""
    share = -sum(step.share for step in steps)
    first, *others = sorted(steps, key=lambda step: -abs(step.share))
    name = named_at(joint, first.effect, first.location)
    if not others:
        return Row(name, share, level)
    names = [named_at(joint, step.effect, step.location) for step in steps]
    parts = tuple(f"{one} {signed_share_words(-step.share)}" for one, step in zip(names, steps, strict=True))
    beside = named_at(joint, others[0].effect, others[0].location) if len(others) == 1 else f"{len(others)} others"
    return Row(f"{name} with {beside}", share, level, parts=parts)


def shown(diagnosis: Diagnosis) -> tuple[Waterfall, ...]:
    """List the joints with a part of the gap, the largest first."""
    parts = (one for one in diagnosis.waterfall if max(one.before, one.left) >= LEAST)
    return tuple(sorted(parts, key=lambda one: -one.before))


def waterfall_figure(diagnosis: Diagnosis) -> go.Figure:
    """Draw the waterfalls of all joints below one another."""
    import plotly.graph_objects as go

    from flexros.report.theme import stacked

    places: list[float] = []
    labels: list[str] = []
    largest, traces = 0.0, []
    for waterfall in shown(diagnosis):
        rows, first = rows_of(waterfall), (places[-1] + 1.5 if places else 0.0)
        of_rows = [_label(row, waterfall.joint) for row in rows]
        own = [first + place for place in _places(of_rows)]
        places += own
        labels += of_rows
        largest = max(largest, *(max(row.begin, row.begin + row.share) for row in rows))
        traces.append(
            go.Waterfall(
                orientation="h",
                measure=["absolute", *["relative"] * (len(rows) - 2), "absolute"],
                x=[row.share for row in rows],
                y=own,
                customdata=[_hover(row, waterfall.joint) for row in rows],
                hovertemplate="%{customdata}<extra></extra>",
                connector={"line": {"color": TOTALS, "width": 1, "dash": "dot"}},
                decreasing={"marker": {"color": REPAIRED}},
                increasing={"marker": {"color": NOMINAL}},
                totals={"marker": {"color": TOTALS}},
                width=0.7,
            )
        )
        # beside the right end of each bar: those that fall would have theirs over the names
        ends = [max(row.begin, row.begin + row.share, 0.0) for row in rows]
        texts = [f" {row.words}" for row in rows]
        traces.append(go.Scatter(x=ends, y=own, text=texts, mode="text", textposition="middle right", hoverinfo="skip"))
    figure = stacked([""], height=round(_ROW * (places[-1] + 1.2)) + 20)
    figure.add_traces(traces)
    figure.update_yaxes(
        range=[places[-1] + 0.6, -0.6],
        showgrid=False,
        tickvals=places,
        ticktext=labels,
        ticks="",
        tickfont={"size": 12},
    )
    figure.update_xaxes(title_text="share of the gap", tickformat=".0%", range=[0, 1.17 * largest])
    figure.update_layout(margin={"l": 132, "r": 8, "t": 16}, showlegend=False)
    return figure


def waterfall_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Write the waterfalls as lines of text, with bars."""
    waterfalls = shown(diagnosis)
    rows = {one.joint: rows_of(one) for one in waterfalls}
    every = [row for of_joint in rows.values() for row in of_joint]
    if not every:
        return ()
    scale = _BAR / max(max(row.begin, row.begin + row.share) for row in every)
    width = max(len(row.name) for row in every)
    lines = []
    for joint, of_joint in rows.items():
        lines.append(joint)
        for row in of_joint:
            ends = sorted((round(scale * max(row.begin, 0.0)), round(scale * max(row.begin + row.share, 0.0))))
            bar = " " * ends[0] + "█" * max(ends[1] - ends[0], 1)
            lines.append(f"  {capital(row.name):<{width}} {row.words:>6}  {bar}")
    return tuple(lines)


def _places(labels: Sequence[str]) -> list[float]:
    """Return where the rows of labels are, a row apart, and farther where a label has more than two lines."""
    heights = [max(1.0, (1 + label.count("<br>")) / 2) for label in labels]
    return [end - (height + 1) / 2 for end, height in zip(accumulate(heights), heights, strict=True)]


def _hover(row: Row, joint: str) -> str:
    return "<br>".join([f"{capital(row.name)}, {joint}: {row.words} of the gap", *row.parts])


def _label(row: Row, joint: str) -> str:
    if row.total and row.name == "before":
        return f"<b>{joint}</b>, before"
    return "<br>".join(wrap(capital(row.name), _LABEL))
