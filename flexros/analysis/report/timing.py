"""Section: timing of the nodes by their stamps; in real time also by the recorder and the plant."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
import plotly.graph_objects as go

from flexros.analysis.report.pace import pace_sentence, pace_tables
from flexros.report.base import AbstractSection, Block, Folded, Paragraph, Picture, TextTable
from flexros.report.number_text import number
from flexros.report.theme import LOGARITHMIC, compact, curve, run_colour, stacked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.loop_timing import TopicTiming
    from flexros.analysis.run_analysis import Analysis
    from flexros.arrays import FloatArray

_BINS = 120
_SHOWN = 3.0
"""Range of the histogram of receive periods in medians, or in multiples of the 99th percentile (chosen)."""


class TimingSection(AbstractSection["Sequence[Analysis]"]):
    """Periods, jitter and missing samples of every topic."""

    title: ClassVar[str] = "Node timing"

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return the pace of the loop, the timing by stamps, the tables, and the periods where they are not exact."""
        several = len(analyses) > 1
        blocks: list[Block] = []
        for lock_step in (False, None):
            labels = [
                analysis.label
                for analysis in analyses
                if analysis.timing.exact and analysis.timing.real_time is lock_step
            ]
            if labels:
                blocks.append(Paragraph(_exact(labels, len(analyses), lock_step is False)))
        blocks += [Paragraph(pace_sentence(analysis, several)) for analysis in analyses if analysis.timing.real_time]
        blocks += [Paragraph(_sentence(analysis)) for analysis in analyses if not analysis.timing.exact]
        if all(analysis.timing.exact and not analysis.timing.real_time for analysis in analyses):
            blocks.append(Folded("Timing of each topic", (_table(analyses),)))
        else:
            blocks += [_table(analyses), *pace_tables(analyses)]
        loose = [
            (f"{analysis.label} {name}" if several else name, periods)
            for analysis in analyses
            for name, periods in _periods(analysis)
        ]
        if loose:
            blocks.append(_picture(loose))
        return tuple(blocks)


class _Periods(NamedTuple):
    """Periods of a topic to be drawn: time [s], all of them and those of the histogram [ms]."""

    time: FloatArray
    all: FloatArray
    counted: FloatArray


def _periods(analysis: Analysis) -> list[tuple[str, _Periods]]:
    """Return the periods by receive times where they are known, else by the stamps that are not exact."""
    arrivals = analysis.timing.arrivals
    if arrivals:
        return [
            (
                f"{arrival.topic}, received",
                _Periods(arrival.step_time, 1e3 * arrival.steps, _within(1e3 * arrival.steps)),
            )
            for arrival in arrivals
        ]
    return [
        (topic.topic, _Periods(topic.step_time, 1e3 * topic.steps, 1e3 * topic.steps[topic.steps < 1.5 * topic.period]))
        for topic in _loop_topics(analysis)
    ]


def _within(steps: FloatArray) -> FloatArray:
    """Count the few longest periods with the longest one shown, so that bars stay narrow."""
    median, p99 = np.percentile(steps, [50.0, 99.0])
    return np.asarray(np.minimum(steps, max(_SHOWN * median, 2.0 * p99)), dtype=np.float64)


def _loop_topics(analysis: Analysis) -> list[TopicTiming]:
    """Return measurement and command where they are not exact; the command only where it differs."""
    states, commands = analysis.timing.topic("joint_states"), analysis.timing.topic("joint_commands")
    loose = [topic for topic in (states, commands) if topic is not None and not topic.exact and len(topic.steps)]
    return loose[:1] if len(loose) == 2 and np.array_equal(loose[0].steps, loose[1].steps) else loose


def _exact(labels: Sequence[str], runs: int, lock_step: bool) -> str:
    who = "" if runs == 1 else "In all runs " if len(labels) == runs else f"In {', '.join(labels)} "
    text = (
        f"{who}{'all' if who else 'All'} stamps are on an exact grid and every measurement has the command of its own "
        "stamp."
    )
    if not lock_step:
        return f"{text} Whether the loop ran in real time or in lock-step is not known."
    return (
        f"{text} In lock-step, where the plant waits for the command, the timing is exact by construction; "
        "it does not show the speed at which the nodes ran."
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
    if any(analysis.timing.real_time and analysis.timing.exact for analysis in analyses):
        caption += " Exact stamps of a run in real time are the planned instants: they show loss, but no jitter."
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


def _picture(topics: Sequence[tuple[str, _Periods]]) -> Picture:
    figure = stacked(["Period from sample to sample", "How often each period occurs"], shared_x=False, gap=92)
    for index, (label, periods) in enumerate(topics):
        colour = run_colour(index)
        hover = "%{x:.4f} s: %{y:.4f} ms"
        figure.add_trace(curve(periods.time, periods.all, label, colour, hover=hover, width=1.0), row=1, col=1)
        count, edges = np.histogram(periods.counted, bins=_BINS)
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
    figure.update_yaxes(title_text="number of samples", row=2, **LOGARITHMIC)
    caption = (
        "Periods of the loop by the stamps of its topics, in real time by the receive times. In the histogram gaps "
        "between stamps are omitted, and receive periods far above the others are counted in the last bar."
    )
    return Picture(figure, caption)
