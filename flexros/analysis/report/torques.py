"""Section: torques against feedforward."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.number_text import number
from flexros.report.theme import INK, REFERENCE, curve, run_colour, stacked

if TYPE_CHECKING:
    from collections.abc import Sequence

    import plotly.graph_objects as go

    from flexros.analysis.run_analysis import Analysis
    from flexros.analysis.tracking import MotorTracking


class TorqueSection(AbstractSection["Sequence[Analysis]"]):
    """Commanded torque and feedforward of each motor, and the difference, which is the feedback."""

    title: ClassVar[str] = "Torques against feedforward"

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return a sentence per run and the picture; none where no commands were recorded."""
        motors = {m.joint: m.linear for analysis in analyses for m in analysis.motors if m.torque is not None}
        if not motors:
            return ()
        titles = [
            text for joint in motors for text in (f"{joint}: command, and feedforward dotted", f"{joint}: feedback")
        ]
        figure = stacked(titles, columns=2, height=200)
        for index, analysis in enumerate(analyses):
            for motor in analysis.motors:
                if motor.joint in motors:
                    _draw(figure, list(motors).index(motor.joint) + 1, motor, analysis.label, index, len(analyses))
        for row, linear in enumerate(motors.values(), start=1):
            figure.update_yaxes(title_text="force [N]" if linear else "torque [Nm]", row=row, col=1)
        figure.update_xaxes(title_text="time since start [s]", row=len(motors))
        caption = "Commanded torque of each motor with the feedforward (dotted), and the feedback added to it."
        return (_shares(analyses, tuple(motors)), Picture(figure, caption))


def _draw(figure: go.Figure, row: int, motor: MotorTracking, label: str, index: int, runs: int) -> None:
    if motor.torque is None or motor.torque_time is None:
        return
    unit = "N" if motor.linear else "Nm"
    hover = f"%{{x:.4f}} s: %{{y:.5g}} {unit}"
    colour = run_colour(index)
    line = curve(motor.torque_time, motor.torque, label, colour, hover=hover, legend=row == 1)
    figure.add_trace(line, row=row, col=1)
    if motor.feedforward is None or motor.feedback is None:
        return
    dotted = curve(
        motor.torque_time,
        motor.feedforward,
        "feedforward" if runs == 1 else f"{label}, feedforward",
        INK if runs == 1 else REFERENCE,
        hover=hover,
        dash="dot",
        legend=row == 1 and runs == 1,
        group=label if runs > 1 else "feedforward",
    )
    figure.add_trace(dotted, row=row, col=1)
    added = curve(motor.torque_time, motor.feedback, label, colour, hover=hover, legend=False)
    figure.add_trace(added, row=row, col=2)


def _shares(analyses: Sequence[Analysis], joints: tuple[str, ...]) -> Block:
    """Return a sentence for one run, a table for several."""
    if len(analyses) == 1:
        return Paragraph(_sentence(analyses[0]))
    rows = []
    for analysis in analyses:
        share = {motor.joint: motor.feedback_share for motor in analysis.motors}
        sizes = (share.get(joint) for joint in joints)
        rows.append((analysis.label, *(number(None if size is None else 1e2 * size, 3) for size in sizes)))
    header = ("Run", *(f"{joint} [%]" for joint in joints))
    return TextTable(header, tuple(rows), "Share of the feedback in the torque, rms over rms.")


def _sentence(analysis: Analysis) -> str:
    shares = [
        f"{number(1e2 * motor.feedback_share, 3)} % at {motor.joint}"
        for motor in analysis.motors
        if motor.feedback_share is not None
    ]
    if not shares:
        return "The log has no feedforward torque, so the share of the feedback is not evaluated."
    text = f"Share of the feedback in the torque (rms over rms): {', '.join(shares)}"
    limited = [
        f"{motor.joint} (for {number(1e2 * motor.saturated_share, 3)} % of the run)"
        for motor in analysis.motors
        if motor.saturated_share
    ]
    return f"{text}; the torque limit was reached at {', '.join(limited)}." if limited else f"{text}."
