"""Section: errors of tool and motors over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Picture
from flexros.report.theme import curve, run_colour, stacked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.run_analysis import Analysis


class ErrorSection(AbstractSection["Sequence[Analysis]"]):
    """Path error, time-synchronised error, orientation error, and tracking error of the motors."""

    title: ClassVar[str] = "Errors over time"

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return one picture of the tool and one of the motors, where the logs contain them."""
        blocks: list[Block] = []
        if any(analysis.path is not None for analysis in analyses):
            blocks.append(tool_errors(analyses))
        if any(motor.tracking is not None for analysis in analyses for motor in analysis.motors):
            blocks.append(_motor_errors(analyses))
        return tuple(blocks)


def tool_errors(analyses: Sequence[Analysis]) -> Picture:
    """Draw the errors of the tool over time, one panel per kind of error and one line per run."""
    turned = any(analysis.path is not None and analysis.path.angle is not None for analysis in analyses)
    titles = [
        "Path error: distance to the commanded path",
        "Time-synchronised error: distance to the commanded position",
    ]
    figure = stacked([*titles, "Orientation error"] if turned else titles)
    for index, analysis in enumerate(analyses):
        path = analysis.path
        if path is None:
            continue
        for row, values in enumerate((path.distance, path.time_difference, path.angle), start=1):
            if values is None:
                continue
            hover = f"%{{x:.4f}} s: %{{y:.4f}} {'mrad' if row == 3 else 'mm'}"
            line = curve(path.run.time, 1e3 * values, analysis.label, run_colour(index), hover=hover, legend=row == 1)
            figure.add_trace(line, row=row, col=1)
    figure.update_yaxes(title_text="error [mm]", rangemode="tozero")
    if turned:
        figure.update_yaxes(title_text="error [mrad]", row=3)
    figure.update_xaxes(title_text="time since start [s]", row=3 if turned else 2)
    return Picture(figure, "Errors of the tool over time.")


def _motor_errors(analyses: Sequence[Analysis]) -> Picture:
    motors = {motor.joint: motor.linear for analysis in analyses for motor in analysis.motors if motor.tracking}
    figure = stacked([f"{joint}: reference minus measured position" for joint in motors], height=190)
    for index, analysis in enumerate(analyses):
        for motor in analysis.motors:
            if motor.time is None or motor.error is None:
                continue
            row = list(motors).index(motor.joint) + 1
            unit = "mm" if motor.linear else "mrad"
            line = curve(
                motor.time,
                1e3 * motor.error,
                analysis.label,
                run_colour(index),
                hover=f"%{{x:.4f}} s: %{{y:.4f}} {unit}",
                legend=row == 1,
            )
            figure.add_trace(line, row=row, col=1)
    for row, linear in enumerate(motors.values(), start=1):
        figure.update_yaxes(title_text="error [mm]" if linear else "error [mrad]", row=row)
    figure.update_xaxes(title_text="time since start [s]", row=len(motors))
    return Picture(figure, "Tracking error of the motors over time.")
