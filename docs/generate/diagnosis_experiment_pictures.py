"""Draw the picture of diagnosis_experiment.md: python docs/generate/diagnosis_experiment_pictures.py [FOLDER]."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from svg_picture import Curve, Panel, picture

from flexros.identify.diagnosis_experiment.course import diagnosis_course
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

ROBOT = "four_mass_linear"
PIECES = 160
"""Pieces of a curve of which the smallest and largest value are drawn."""
SECONDS = (0, 10, 20, 30, 40, 50)
COLOURS = {
    "creep": "#c8541b",
    "presliding": "#7a4fa3",
    "multisine": "#1b6fc8",
    "biased": "#1b9c8c",
    "moves": "#888888",
    "steps": "#b8860b",
}


def thinned(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Reduce a curve to the smallest and largest value of each of many equal pieces."""
    pieces = np.array_split(np.arange(len(time)), PIECES)
    keep = sorted({int(piece[pick(values[piece])]) for piece in pieces for pick in (np.argmin, np.argmax)})
    return time[keep], values[keep]


def course() -> str:
    """Draw motor position and torque over time, part by part."""
    scenario = load_scenario("diagnosis").with_values({"robot": ROBOT})
    assert scenario.diagnosis is not None
    experiment = Experiment.prepare(scenario)
    log = closed_loop(experiment)
    assert log.joint_commands is not None
    time = np.arange(experiment.n_samples, dtype=float) * experiment.sample_time
    made = diagnosis_course(
        scenario.diagnosis,
        experiment.nominal,
        scenario.controller,
        experiment.sample_time,
        scenario.seed,
        experiment.start,
    )
    rows: list[list[Panel]] = []
    for title, values, ticks in (
        ("motor position [rad]", log.joint_states.position, (-50, -25, 0, 25, 50, 75, 100)),
        ("torque [Nm]", log.joint_commands.effort, (-20, -10, 0, 10, 20)),
    ):
        assert values is not None
        curves = [Curve(*thinned(time, values[:, 0]), colour="#cccccc", width=0.7)]
        for part in made.parts:
            if part.name in COLOURS:
                inside = (time >= part.begin) & (time <= part.end)
                x, y = thinned(time[inside], values[inside, 0])
                curves.append(Curve(x, y, label=part.name if not rows else "", colour=COLOURS[part.name], width=0.8))
        rows.append([Panel(f"{ROBOT}, seed 1", "time [s]", title, curves, SECONDS, ticks, logarithmic=False)])
    return picture(rows)


def main(folder: Path) -> None:
    """Write the picture.

    Args:
        folder: Where to.
    """
    (folder / "diagnosis_course.svg").write_text(course(), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "explanation")
