"""Draw the picture of the guide to friction at constant speeds: friction_picture.py [PICTURE.svg]."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from svg_picture import Curve, Panel, picture

from flexros.identify.friction.measurement import measure_friction
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

if TYPE_CHECKING:
    from flexros.logs.time_series import Log

SPEEDS = (0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2, 1.6)
"""Speeds of the moves [rad/s]."""

COLOURS = ("#0072b2", "#d55e00", "#009e73")
PICTURE = Path(__file__).parents[1] / "pictures" / "friction.svg"


def log(speed: float) -> Log:
    """Simulate the move out and back at one speed [rad/s]."""
    scenario = load_scenario("friction_two_mass").with_values({"trajectory.time_law.speed": speed})
    return closed_loop(Experiment.prepare(scenario))


def main() -> None:
    """Run the moves, fit the laws, write the picture."""
    measured = measure_friction([log(speed) for speed in SPEEDS], "motor_1")
    sizes = np.geomspace(1e-4, 1.7, 400)
    speed = np.concatenate((-sizes[::-1], sizes))
    curves = [
        Curve(speed, fit.law.evaluate(speed, fit.values), f"equation {fit.law.equation}", colour, 1.5)
        for fit, colour in zip(measured.fits, COLOURS, strict=True)
    ]
    points = Curve(measured.points.speed, measured.points.torque, "measured", "#1b1f24", marks=True)
    panel = Panel(
        "motor_1", "speed [rad/s]", "friction torque [Nm]", [points, *curves],
        (-2, -1, 0, 1, 2), (-12, -8, -4, 0, 4, 8, 12), logarithmic=False,
    )  # fmt: skip
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE
    file.write_text(picture([[panel]]), encoding="utf-8")


if __name__ == "__main__":
    main()
