"""Pictures of the study, like figures 3 to 8 of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.response_noise import response_noise
from flexros.report.drawing import Band, Drawing, Line, Panel
from flexros.report.theme import run_colour
from flexros.validation.campaigns.study.choices import REASONABLE, SIX
from flexros.validation.campaigns.study.figures import normalised_costs, of_gears, sorted_values, springs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray
    from flexros.validation.campaigns.study.jobs import Study

_WITH_DAMPERS = ("LLSM15U", "LLS15U", "LLS15O")
_LARGEST_COST = 100.0


def pictures(study: Study) -> dict[str, Drawing]:
    """Draw all pictures of the study.

    Args:
        study: The study.

    Returns:
        Pictures by file name without ending, in the order of the paper.
    """
    gear, spring = of_gears(study), np.zeros(len(study.problem.names), dtype=bool)
    spring[springs(study)] = True
    every = [kind.name for kind in SIX]
    return {
        "costs_optimal_weights": _costs(study, "optimal"),
        "costs_user_weights": _costs(study, "user"),
        "springs_of_gears": _parameters(study, every, [("", spring & gear)]),
        "springs_of_arm": _parameters(study, every, [("", spring & ~gear)]),
        "dampers": _parameters(study, _WITH_DAMPERS, [(", gears", ~spring & gear), (", arm", ~spring & ~gear)]),
        "frequency_responses": _responses(study),
    }


def _costs(study: Study, weights: str) -> Drawing:
    """Normalised LLS costs of all models, sorted (figures 3 and 4)."""
    curves, legend = [], []
    for place, kind in enumerate(SIX):
        costs = normalised_costs(study, kind.name, weights)
        number = np.arange(1.0, len(costs) + 1.0)
        curves.append(Line(number, np.minimum(costs, 2 * _LARGEST_COST), run_colour(place), 2.0))
        legend.append((kind.name, run_colour(place)))
    ends = (1.0, float(max(2, len(number))))
    title = f"LLS cost with {weights} weights over the lowest, sorted"
    levels = (REASONABLE,) if weights == "user" else ()
    panel = Panel(title, ends, (0.9, _LARGEST_COST), tuple(curves), levels=levels)
    return Drawing((panel,), 1, width=620, height=280, legend=tuple(legend))


def _parameters(study: Study, kinds: Sequence[str], groups: Sequence[tuple[str, BoolArray]]) -> Drawing:
    """Parameters over those of the best model, models sorted by user cost (figures 5 to 7)."""
    panels, names = [], study.problem.names
    for kind in kinds:
        for suffix, chosen in groups:
            ratio = sorted_values(study, kind)[:, chosen]
            number = np.arange(1.0, len(ratio) + 1.0)
            lines = [Line(number, column, run_colour(place)) for place, column in enumerate(ratio.T)]
            ends = (1.0, float(max(2, len(number))))
            panels.append(Panel(f"{kind}{suffix}", ends, (0.02, 50.0), tuple(lines), levels=(0.5, 2.0)))
    columns = len(groups) if len(groups) > 1 else 3
    legend = tuple(
        (name, run_colour(place)) for place, name in enumerate(np.array(names)[groups[0][1]]) if len(groups) == 1
    )
    return Drawing(tuple(panels), columns, width=330 if columns < 3 else 240, legend=legend)


def _responses(study: Study) -> Drawing:
    """Measured and fitted magnitudes of one position with one standard deviation (figure 8)."""
    problem, place = study.problem, study.single
    measured, frequency = problem.responses[place], problem.frequency
    model = np.abs(problem.model_at(study.best.values).response(study.best.values)[place])
    size, noise = np.abs(measured.response), response_noise(measured)
    deviation = np.zeros_like(size) if noise is None else np.sqrt(noise.variance)
    low, high = float(size[size > 0].min()), float(size.max())
    panels = []
    for row, output in enumerate(measured.output_names):
        for column, torque in enumerate(measured.input_names):
            here = (slice(None), row, column)
            floor = np.maximum(size[here] - deviation[here], low / 10)
            items: tuple[Line | Band, ...] = (
                Band(frequency, floor, size[here] + deviation[here], "#cfd8e3"),
                Line(frequency, model[here], run_colour(1), 2.0),
                Line(frequency, size[here], run_colour(0), 0.9),
            )
            ends = (float(frequency[0]), float(frequency[-1]))
            panels.append(Panel(f"{torque} to {output}", ends, (low, 2 * high), items, x_log=True))
    legend = (("measured, shaded: one standard deviation", run_colour(0)), ("best LLS15U model", run_colour(1)))
    return Drawing(tuple(panels), len(measured.input_names), width=150, height=110, legend=legend)
