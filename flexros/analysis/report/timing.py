"""Section: timing of the nodes, as the stamps tell it."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
import plotly.graph_objects as go

from flexros.analysis.figures_table import number
from flexros.analysis.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.analysis.report.theme import compact, curve, run_colour, stacked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.loop_timing import TopicTiming
    from flexros.analysis.run_analysis import Analysis

_BINS = 120


class TimingSection(AbstractSection):
    """Periods, jitter and missing samples of every topic."""

    title: ClassVar[str] = "Node timing"

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return what the stamps say, the table of topics, and the periods of the runs that are not exact."""
        exact = [analysis.label for analysis in analyses if analysis.timing.exact]
        blocks: list[Block] = [Paragraph(_exact(exact, len(analyses)))] if exact else []
        blocks += [Paragraph(_sentence(analysis)) for analysis in analyses if not analysis.timing.exact]
        blocks.append(_table(analyses))
        loose = [
            (f"{one.label} {topic.topic}" if len(analyses) > 1 else topic.topic, topic)
            for one in analyses
            for topic in _loop_topics(one)
        ]
        if loose:
            blocks.append(_picture(loose))
        return tuple(blocks)


def _loop_topics(analysis: Analysis) -> list[TopicTiming]:
    """Return measurement and command where they are not exact; the command only where it differs."""
    states, commands = analysis.timing.topic("joint_states"), analysis.timing.topic("joint_commands")
    loose = [topic for topic in (states, commands) if topic is not None and not topic.exact and len(topic.steps)]
    return loose[:1] if len(loose) == 2 and np.array_equal(loose[0].steps, loose[1].steps) else loose


def _exact(labels: Sequence[str], runs: int) -> str:
    who = "" if runs == 1 else "In all runs " if len(labels) == runs else f"In {', '.join(labels)} "
    return (
        f"{who}{'all' if who else 'All'} stamps lie on an exact grid and every measurement has the command of its own "
        "stamp. In lock-step, where the plant waits for the command, the timing is exact by construction; "
        "this says nothing of the speed at which the nodes ran."
    )


def _sentence(analysis: Analysis) -> str:
    timing = analysis.timing
    gaps = [f"{topic.topic} {gap.missing} after {gap.time:.4f} s" for topic in timing.topics for gap in topic.gaps]
    text = (
        f"{analysis.label}: {number(1e2 * timing.answered, 5)} % of the measurements have a command of the same stamp"
    )
    if not gaps:
        return f"{text}; no sample is missing."
    named = ", ".join(gaps[:6]) + (", and more" if len(gaps) > 6 else "")
    return f"{text}; samples are missing: {named}."


def _table(analyses: Sequence[Analysis]) -> TextTable:
    same: dict[tuple[tuple[str, ...], ...], list[str]] = {}
    for analysis in analyses:
        same.setdefault(_run_rows(analysis), []).append(analysis.label)
    rows: list[tuple[str, ...]] = []
    for figures, labels in same.items():
        if len(analyses) > 1:
            rows.append((", ".join(labels),))
        rows += figures
    header = (
        "Topics",
        "messages",
        "first at [s]",
        "mean period [ms]",
        "jitter std [µs]",
        "jitter 99 % [µs]",
        "jitter max [µs]",
        "missing",
    )
    caption = (
        "Timing of the topics by their stamps; those with the same figures share a row; jitter is without the gaps."
    )
    return TextTable(header, tuple(rows), caption)


def _run_rows(analysis: Analysis) -> tuple[tuple[str, ...], ...]:
    figures = [(topic.topic, _topic_row(topic)) for topic in analysis.timing.topics]
    different = dict.fromkeys(row for _, row in figures)
    return tuple((", ".join(name for name, row in figures if row == figure), *figure) for figure in different)


def _topic_row(topic: TopicTiming) -> tuple[str, ...]:
    return (
        str(topic.count),
        number(topic.start),
        number(1e3 * topic.mean_period, 5),
        number(1e6 * topic.jitter_std),
        number(1e6 * topic.jitter_p99),
        number(1e6 * topic.jitter_max),
        str(topic.missed),
    )


def _picture(topics: Sequence[tuple[str, TopicTiming]]) -> Picture:
    figure = stacked(["Period from sample to sample", "How often each period occurs"], shared_x=False, gap=92)
    for index, (label, topic) in enumerate(topics):
        colour = run_colour(index)
        hover = "%{x:.4f} s: %{y:.4f} ms"
        figure.add_trace(curve(topic.step_time, 1e3 * topic.steps, label, colour, hover=hover, width=1.0), row=1, col=1)
        whole = 1e3 * topic.steps[topic.steps < 1.5 * topic.period]
        count, edges = np.histogram(whole, bins=_BINS)
        bars = go.Bar(
            x=compact(0.5 * (edges[1:] + edges[:-1])),
            y=count,
            name=label,
            marker={"color": colour, "opacity": 0.65},
            hovertemplate="%{x:.4f} ms: %{y} times<extra></extra>",
            showlegend=False,
            legendgroup=label,
        )
        figure.add_trace(bars, row=2, col=1)
    figure.update_layout(barmode="overlay", bargap=0)
    figure.update_xaxes(title_text="time since start [s]", row=1)
    figure.update_xaxes(title_text="period [ms]", row=2)
    figure.update_yaxes(title_text="period [ms]", row=1)
    figure.update_yaxes(title_text="number of samples", type="log", row=2)
    caption = "Periods of the loop by the stamps of its topics; gaps are left out of the histogram."
    return Picture(figure, caption)
