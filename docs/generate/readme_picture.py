"""Draw the picture of the README: path errors with three feedforwards, and a gap before and after its patch.

Usage: readme_picture.py [FOLDER [EFFECT ...]]; the effects that compete in the diagnosis are all if none is named.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from svg_picture import Curve, Panel, picture

from flexros.analysis import analyse
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

FEEDFORWARDS = {
    "circle_fj": ("flexible joint", "#c2571a"),
    "circle_dae": ("DAE", "#1f5fa8"),
    "circle_dae2": ("DAE, 2nd order", "#2c8a4b"),
}
ROBOT, HIDDEN = "four_mass_linear", "coulomb_friction@motor_1:level=0.05"


def path_errors() -> Panel:
    """Draw the path error of E12 on the circle of Paper B over time, logarithmic."""
    curves = []
    for name, (label, colour) in FEEDFORWARDS.items():
        error = analyse(closed_loop(Experiment.prepare(load_scenario(name)))).path
        assert error is not None
        size = np.log10(np.maximum(np.abs(error.distance) * 1e3, 1e-5))
        curves.append(Curve(error.run.time, size, label=label, colour=colour))
    label = "log10 of the path error [mm]"
    return Panel(
        "E12, circle of Paper B",
        "time [s]",
        label,
        curves,
        (0, 0.1, 0.2, 0.3, 0.4),
        (-5, -4, -3, -2, -1, 0, 1, 2, 3),
        False,
    )


def closed_gap(effects: tuple[str, ...] = ()) -> Panel:
    """Draw prediction errors of a log with hidden friction, with the nominal model and with the patch."""
    changes = {"robot": ROBOT, "diagnosis.length": 12, "plant.effects": [HIDDEN]}
    log = closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(changes, "picture")))
    model = Experiment.prepare(load_scenario("diagnosis").with_values({"robot": ROBOT}, "picture")).nominal
    settings = DiagnosisSettings(where=None, next_experiment=None, search=SearchSettings(effects=effects))
    result = diagnose(checked_log(log, model, name="hidden"), model, settings=settings)
    assert result.after is not None
    curves = []
    for explanation, label, colour in (
        (result.before, "nominal model", "#c2571a"),
        (result.after, "with its patch", "#1f5fa8"),
    ):
        errors = explanation.fit.innovations[:, 0] * 1e3
        time = np.arange(len(errors), dtype=float) * result.record.sample_time
        curves.append(Curve(time, errors, label=label, colour=colour, width=0.7))
    bound = 5.0 * np.ceil(1.5 * np.abs(curves[0].y).max() / 5.0)  # room for the legend
    ticks = tuple(np.linspace(-bound, bound, 5))
    cause = result.diagnosis.causes[0]
    title = f"{ROBOT}: {cause.effect.replace('_', ' ')} found"
    return Panel(title, "time [s]", "prediction error [mrad]", curves, (0, 2, 4, 6, 8), ticks, False)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "pictures"
    folder.mkdir(exist_ok=True)
    (folder / "overview.svg").write_text(picture([[path_errors(), closed_gap(tuple(sys.argv[2:]))]]), encoding="utf-8")
