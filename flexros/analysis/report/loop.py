"""Report of the loops of a controller: margins, Bode, Nyquist, sensitivity and steps over all plants."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.atomic_file import write_result
from flexros.control.design.margins import frequency_grid, loop_response, step_response
from flexros.report.base import Paragraph, Picture, TextTable
from flexros.report.number_text import number
from flexros.report.page import Chapter, page_html
from flexros.report.theme import INK, LOGARITHMIC, REFERENCE, curve, run_colour, stacked

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from flexros.analysis.control_loops import ControlLoop
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.control.design.margins import LoopMargins, LoopResponse
    from flexros.control.design.plants import SampledPlants
    from flexros.control.linear_controller import LinearController

_STEP = 1.0
"""Length of the step responses [s] (chosen)."""
_NYQUIST = 3.0
"""Half the side of the Nyquist picture [1] (chosen)."""
_UPRIGHT = 3
"""Most loops of which each is a column, so that the table fits a phone (chosen)."""
_TURN = 0.01
"""Largest step of a curve between two points, of 1 / (1 + |L|) of the Nyquist picture or in decades (chosen)."""


def write_loop_report(loops: Mapping[str, Sequence[ControlLoop]], file: Path, *, title: str) -> None:
    """Write margins and pictures of the loops of one or more controllers.

    Args:
        loops: Loops of each controller by its name, those of one controller with all its poses.
        file: The HTML file; an existing one is replaced when the new one is complete.
        title: Heading.

    Raises:
        InputError: The file cannot be written.
    """
    chapters, plants = [], 0
    for name, of_law in loops.items():
        plants = sum(len(loop.plants) for loop in of_law)
        for number_, loop in enumerate(of_law, start=1):
            pictures = [
                picture
                for motor in range(loop.plants.B.shape[-1])
                for picture in loop_pictures(loop.plants, loop.controller, motor)
            ]
            heading = " ".join(
                [*([name] if len(loops) > 1 else ["Loops"]), *([f"pose {number_}"] if len(of_law) > 1 else [])]
            )
            chapters.append(Chapter(heading, (*loop_table(loop.margins), *pictures)))
    sample_time = next(iter(loops.values()))[0].plants.sample_time
    write_result(
        file,
        page_html(title, f"{plants} plant{'s' * (plants > 1)}, sample time {1e3 * sample_time:g} ms", chapters),
        "report",
    )


def common_beginning(labels: Sequence[str]) -> str:
    """Return the words with which all names begin, without the last word of any; empty for a single name."""
    words = [label.split() for label in labels]
    same = 0
    while len(words) > 1 and same < min(map(len, words)) - 1 and len({each[same] for each in words}) == 1:
        same += 1
    return " ".join(words[0][:same]) if words else ""


def _short(labels: Sequence[str]) -> list[str]:
    beginning = common_beginning(labels)
    return [label.removeprefix(beginning).strip() for label in labels]


def loop_table(margins: Sequence[LoopMargins]) -> tuple[Paragraph, TextTable]:
    """Return the smallest margins in a sentence, and a table of all.

    Args:
        margins: Margins of every plant and motor.
    """
    return _sentence(margins), _table(margins)


def loop_pictures(plants: SampledPlants, controller: LinearController, motor: int) -> tuple[Picture, ...]:
    """Return Bode, Nyquist and step pictures of the loop at one motor, the other loops closed.

    Args:
        plants: All sampled plants.
        controller: The controller.
        motor: Number of the motor, from 0.
    """
    return _pictures(plants, controller, loop_response(plants, controller, frequency_grid(plants.sample_time)), motor)


def _drawn(frequency: FloatArray, loop: ComplexArray) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Return the points that a smooth curve needs: many at resonances, few where the loop gain hardly changes."""
    near = loop / (1.0 + np.abs(loop))  # bounded: what is far outside of the Nyquist picture needs no points
    step = np.hypot(np.abs(np.diff(near)), np.diff(np.log10(frequency)))
    passed = np.floor(np.concatenate([[0.0], np.cumsum(step)]) / _TURN)
    kept = np.flatnonzero(np.diff(passed, prepend=-1.0))
    return np.union1d(kept, [len(loop) - 1])


def _sentence(entries: Sequence[LoopMargins]) -> Paragraph:
    stable = all(entry.largest_eigenvalue < 1.0 for entry in entries)
    if not stable:
        bad = next(entry for entry in entries if entry.largest_eigenvalue >= 1.0)
        return Paragraph(f"The loop is unstable with {bad.plant}.", "lead")
    text = (
        f"All loops are stable. Smallest margins: gain {number(min(e.gain_up for e in entries), 3)}, phase "
        f"{number(float(np.degrees(min(e.phase for e in entries))), 3)} degrees, delay "
        f"{number(1e3 * min(e.delay for e in entries), 3)} ms; largest sensitivity "
        f"{number(max(e.sensitivity for e in entries), 3)}."
    )
    return Paragraph(text, "lead")


def _table(entries: Sequence[LoopMargins]) -> TextTable:
    header = ("Plant", "Motor", "Eigenvalue", "Gain margin", "Phase [deg]", "Delay [ms]", "Crossover [Hz]", "max |S|",
              "max |T|", "Overshoot [%]", "Settling [s]")  # fmt: skip
    plants = [entry.plant for entry in entries]
    rows = tuple(
        (
            plant,
            f"motor_{entry.motor + 1}",
            f"{entry.largest_eigenvalue:.5f}",
            f"{number(entry.gain_down, 3)} to {number(entry.gain_up, 3)}",
            number(float(np.degrees(entry.phase)), 3),
            number(1e3 * entry.delay, 3),
            number(entry.crossover_hz, 3),
            number(entry.sensitivity, 3),
            number(entry.complementary, 3),
            number(100 * entry.overshoot, 3),
            number(entry.settling, 3),
        )
        for plant, entry in zip(_short(plants), entries, strict=True)
    )
    of = common_beginning(plants)
    caption = f"Margins of each loop with the others closed{f'; plants: {of}' if of else ''}."
    if len(rows) > _UPRIGHT:
        return TextTable(header, rows, caption, left=2)
    upright = [tuple(cells) for cells in zip(header, *rows)]
    if len(set(upright[0][1:])) == 1:  # one plant, which the first line of the page names
        del upright[0]
    return TextTable(upright[0], tuple(upright[1:]), caption)


def _pictures(
    plants: SampledPlants, controller: LinearController, response: LoopResponse, motor: int
) -> tuple[Picture, ...]:
    """Return Bode, Nyquist, sensitivity and step pictures of the loop at one motor."""
    bode = stacked(
        ("Loop gain, magnitude", "Loop gain, phase", "Sensitivity and complementary sensitivity"), height=210
    )
    nyquist, steps = stacked(("Nyquist",), height=520), stacked(("Step of the reference",), height=240)
    samples = round(_STEP / plants.sample_time)
    time = np.asarray(np.arange(samples) * plants.sample_time, dtype=float)
    for number_, label in enumerate(_short(plants.labels)):
        whole, colour = response.loop[number_, :, motor], run_colour(number_)
        phase = np.degrees(np.unwrap(np.angle(whole)))
        points = _drawn(response.frequency, whole)
        frequency, L = response.frequency[points], whole[points]
        _draw(bode, frequency, _decibel(L), label, colour, 1, "Hz", "dB", legend=True)
        _draw(bode, frequency, phase[points], label, colour, 2, "Hz", "degrees")
        _draw(bode, frequency, _decibel(1.0 / (1.0 + L)), label, colour, 3, "Hz", "dB")
        _draw(bode, frequency, _decibel(L / (1.0 + L)), label, colour, 3, "Hz", "dB", dash="dot")
        _draw(nyquist, L.real, L.imag, label, colour, 1, "", "", legend=True)
        values = np.clip(step_response(plants, controller, number_, motor, samples), -10.0, 10.0)
        _draw(steps, time, values, label, colour, 1, "s", "1", legend=True)
    bode.update_xaxes(LOGARITHMIC)
    bode.update_xaxes(title_text="frequency [Hz]", row=3, col=1)
    for row, text in enumerate(("dB", "degrees", "dB, T dotted"), start=1):
        bode.update_yaxes(title_text=text, row=row, col=1)
    angle = np.linspace(0.0, 2 * np.pi, 181)
    _draw(nyquist, np.cos(angle), np.sin(angle), "unit circle", REFERENCE, 1, "", "", legend=True, dash="dot")
    nyquist.add_scatter(
        x=[-1.0], y=[0.0], mode="markers", marker={"symbol": "x", "size": 9, "color": INK}, showlegend=False,
        hovertemplate="-1<extra></extra>",
    )  # fmt: skip
    nyquist.update_xaxes(range=[-_NYQUIST, _NYQUIST], title_text="real part", constrain="domain")
    nyquist.update_yaxes(range=[-_NYQUIST, _NYQUIST], title_text="imaginary part", scaleanchor="x", constrain="domain")
    steps.update_xaxes(title_text="time [s]")
    name = f"motor_{motor + 1}"
    return (
        Picture(bode, f"Bode picture of the loop at {name}, and its sensitivities."),
        Picture(nyquist, f"Nyquist picture of the loop at {name}, with the unit circle; the cross is -1."),
        Picture(steps, f"Position of {name} after a unit step of its reference in the linear loop."),
    )


def _decibel(values: ComplexArray) -> FloatArray:
    return np.asarray(20 * np.log10(np.maximum(np.abs(values), 1e-12)))


def _draw(
    figure: Any, x: FloatArray, y: FloatArray, label: str, colour: str, row: int, x_unit: str, y_unit: str, *,
    legend: bool = False, dash: str = "solid",
) -> None:  # fmt: skip
    line = curve(
        x, y, label, colour, hover=f"%{{x:.4g}} {x_unit}: %{{y:.4g}} {y_unit}", legend=legend, dash=dash, group=label
    )
    figure.add_trace(line, row=row, col=1)
