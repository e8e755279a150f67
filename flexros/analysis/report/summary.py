"""Section: verdict in a sentence, and main figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.analysis.frequency_responses import relative_deviation
from flexros.analysis.pace import Pacing
from flexros.analysis.report.pace import missed_text
from flexros.report.base import AbstractSection, Block, Paragraph, TextTable, Tiles
from flexros.report.number_text import number, percent

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.frequency_responses import LogResponses
    from flexros.analysis.loop_timing import TopicTiming
    from flexros.analysis.run_analysis import Analysis
    from flexros.identify.frf.frequency_response import FrequencyResponse


class SummarySection(AbstractSection["Sequence[Analysis]"]):
    """Verdict; tiles for a single run, a row per run for several."""

    title: ClassVar[str] = ""

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return the verdict and the main figures."""
        main = Tiles(_tiles(analyses[0])) if len(analyses) == 1 else _table(analyses)
        return (Paragraph(verdict(analyses), "lead"), main)


def verdict(analyses: Sequence[Analysis]) -> str:
    """Summarise the runs in one or two sentences with figures."""
    if len(analyses) == 1:
        return _one_run(analyses[0])
    known = [(analysis.path.path.maximum, analysis.label) for analysis in analyses if analysis.path is not None]
    if not known:
        what = "a path" if any(analysis.responses for analysis in analyses) else "the tool and its reference"
        unknown = f"{len(analyses)} runs, none with {what}: only the motor side is evaluated"
        return f"{unknown}. {_timing(analyses)}"
    (best, best_label), (worst, worst_label) = min(known), max(known)
    return (
        f"Of {len(known)} runs, {best_label} stayed closest to its path, within {_mm(best)} mm; "
        f"{worst_label} left it farthest, by {_mm(worst)} mm. {_timing(analyses)}"
    )


def _one_run(analysis: Analysis) -> str:
    followed = _followed(analysis)
    if analysis.responses is not None:
        return f"{_experiment(analysis.responses)}{f'; {followed}' if followed else ''}. {_timing([analysis])}"
    if analysis.path is None:
        tool = "The tool was not recorded with its reference, so only the motor side is evaluated"
        return f"{tool}{f': {followed}' if followed else ''}. {_timing([analysis])}"
    tool = (
        f"The tool stayed within {_mm(analysis.path.path.maximum)} mm of its commanded {analysis.path.shape} "
        f"(rms {_mm(analysis.path.path.rms)} mm)"
    )
    return f"{tool}{f'; {followed}' if followed else ''}. {_timing([analysis])}"


def _experiment(responses: LogResponses) -> str:
    if not responses.positions:
        return "An identification experiment whose frequency responses were not estimated"
    first, count = responses.positions[0], len(responses.positions)
    return (
        f"An identification experiment: frequency responses of {len(first.output_names)} "
        f"motor{'s' if len(first.output_names) > 1 else ''} in {count} position{'s' if count > 1 else ''} "
        f"from {number(first.frequency[0], 3)} to {number(first.frequency[-1], 3)} Hz"
    )


def _followed(analysis: Analysis) -> str:
    tracked = [motor for motor in analysis.motors if motor.tracking is not None]
    if not tracked:
        return ""
    worst = max(tracked, key=lambda motor: motor.tracking.maximum if motor.tracking else 0.0)
    size = worst.tracking.maximum if worst.tracking else 0.0
    text = f"the motors followed within {number(1e3 * size, 3)} {'mm' if worst.linear else 'mrad'}"
    shares = [motor.feedback_share for motor in tracked if motor.feedback_share is not None]
    if not shares:
        return text
    # Rms over rms: where there is no feedforward the share is 1.
    most = "all" if abs(max(shares) - 1.0) < 1e-9 else f"at most {number(1e2 * max(shares), 2)} %"
    return f"{text}, with {most} of the torque from feedback"


def _timing(analyses: Sequence[Analysis]) -> str:
    return " ".join(filter(None, (_loss(analyses), _pace(analyses))))


def _pace(analyses: Sequence[Analysis]) -> str:
    """Describe the pace of the runs in real time by the worst of them."""
    pacings = [analysis.timing.pacing for analysis in analyses if analysis.timing.pacing is not None]
    late = max((pacing.late_share for pacing in pacings if pacing.late_share is not None), default=None)
    missed = max((pacing.missed_commands for pacing in pacings if pacing.missed_commands is not None), default=None)
    parts = [] if late is None else [f"{number(1e2 * late, 3)} % of the cycles began late"]
    if missed is not None:
        parts.append(missed_text(Pacing(missed_commands=missed)))
    most = "at most " if len(pacings) > 1 else ""
    return f"In real time {most}{' and '.join(parts)}." if parts else ""


def _loss(analyses: Sequence[Analysis]) -> str:
    if all(analysis.timing.exact for analysis in analyses):
        if any(analysis.timing.real_time for analysis in analyses):
            return "No sample is missing."
        return "No sample is missing and every stamp is exact."
    missed = sum(topic.missed for analysis in analyses for topic in analysis.timing.topics)
    unanswered = sum(analysis.timing.unanswered for analysis in analyses)
    if missed == 0 and unanswered == 0:
        return "No sample is missing."
    return f"{missed} samples are missing and {unanswered} measurements have no command of the same stamp."


def _mm(metres: float) -> str:
    return number(1e3 * metres, 3)


def _tiles(analysis: Analysis) -> tuple[tuple[str, str, str, str], ...]:
    tiles = []
    if analysis.path is not None:
        path, synchronised = analysis.path.path, analysis.path.synchronised
        tiles.append(
            ("Path error, max", _mm(path.maximum), "mm", f"rms {_mm(path.rms)} mm, at {path.time_of_maximum:.3f} s")
        )
        below = f"rms {_mm(synchronised.rms)} mm"
        tiles.append(("Time-synchronised error, max", _mm(synchronised.maximum), "mm", below))
    if analysis.responses is not None and analysis.responses.positions:
        tiles.append(_response_tile(analysis.responses.positions))
    tracked = [motor.tracking for motor in analysis.motors if motor.tracking is not None]
    if tracked:
        worst = max(tracked, key=lambda statistics: statistics.maximum)
        unit = "mm" if analysis.motors[0].linear else "mrad"
        below = f"rms {number(1e3 * worst.rms, 3)} {unit}"
        tiles.append(("Motor tracking error, max", number(1e3 * worst.maximum, 3), unit, below))
    states = analysis.timing.topic("joint_states")
    if states is not None:
        tiles.append(_period_tile(analysis, states))
    return tuple(tiles)


def _response_tile(positions: Sequence[FrequencyResponse]) -> tuple[str, str, str, str]:
    """Return the standard deviation of the diagonal responses, of the motor where it is largest."""
    shares = [share for response in positions for share in relative_deviation(response).values() if share is not None]
    below = f"of the diagonal, worst median of {len(positions)} positions"
    worst = percent(max(shares)) if shares else "-"
    return "Standard deviation of the responses", worst, "%", below if len(positions) > 1 else "of the diagonal, median"


def _period_tile(analysis: Analysis, states: TopicTiming) -> tuple[str, str, str, str]:
    """Return the period of the loop: as reported by the plant, as received, or by the stamps."""
    pacing, arrival = analysis.timing.pacing, analysis.timing.arrival("joint_states")
    if pacing is not None and pacing.period_median is not None and pacing.late_share is not None:
        below = f"late {number(1e2 * pacing.late_share, 3)} %, missed {number(pacing.missed_commands)}"
        return "Loop period, median", number(1e3 * pacing.period_median), "ms", below
    if arrival is not None:
        below = f"jitter std {number(1e6 * arrival.jitter_std, 3)} µs"
        return "Loop period, received", number(1e3 * arrival.period_median), "ms", below
    exact = "by the stamps" if analysis.timing.real_time else "exact"
    below = exact if states.exact else f"jitter std {number(1e6 * states.jitter_std, 3)} µs"
    return "Loop period, mean", number(1e3 * states.mean_period), "ms", below


def _table(analyses: Sequence[Analysis]) -> TextTable:
    header = (
        "Run",
        "path error, max [mm]",
        "rms [mm]",
        "time-synchronised, max [mm]",
        "feedback share, max [%]",
        "missing",
    )
    rows = []
    for analysis in analyses:
        path = analysis.path
        shares = [motor.feedback_share for motor in analysis.motors if motor.feedback_share is not None]
        rows.append(
            (
                analysis.label,
                "-" if path is None else _mm(path.path.maximum),
                "-" if path is None else _mm(path.path.rms),
                "-" if path is None else _mm(path.synchronised.maximum),
                number(1e2 * max(shares), 3) if shares else "-",
                str(sum(topic.missed for topic in analysis.timing.topics)),
            )
        )
    return TextTable(header, tuple(rows), "The runs side by side; all figures are in a table further down.")
