"""Picture of two signals of the nominal model with each controller over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.report.base import Picture
from flexros.report.theme import curve, run_colour, stacked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class NominalRun:
    """Two signals of the nominal model with a controller.

    Attributes:
        name: Name of the controller.
        time: Time [s], shape (n,).
        motion: Motion of the tool [mm], shape (n,).
        torque: Torque of the motors [unit of the picture], shape (n,).
    """

    name: str
    time: FloatArray
    motion: FloatArray
    torque: FloatArray


@dataclass(frozen=True)
class ShownSignal:
    """How a signal is written.

    Attributes:
        title: Above its picture.
        axis: At its axis.
        unit: Unit of its values.
    """

    title: str
    axis: str
    unit: str


def run_picture(runs: Sequence[NominalRun], motion: ShownSignal, torque: ShownSignal, caption: str) -> Picture:
    """Draw the runs, one above the other.

    Args:
        runs: The runs.
        motion: How the motion is written.
        torque: How the torque is written.
        caption: Text below the picture.
    """
    figure = stacked((motion.title, torque.title), height=260)
    for index, run in enumerate(runs):
        for row, (values, unit) in enumerate(((run.motion, motion.unit), (run.torque, torque.unit)), start=1):
            hover = f"%{{x:.3f}} s: %{{y:.4g}} {unit}"
            line = curve(run.time, values, run.name, run_colour(index), hover=hover, legend=row == 1)
            figure.add_trace(line, row=row, col=1)
    figure.update_yaxes(title_text=motion.axis, row=1, col=1)
    figure.update_yaxes(title_text=torque.axis, row=2, col=1)
    figure.update_xaxes(title_text="time [s]", row=2, col=1)
    return Picture(figure, caption)
