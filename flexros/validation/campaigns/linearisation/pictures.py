"""Pictures of the study: errors over the size of each kind of deviation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.report.drawing import Band, Drawing, Line, Panel
from flexros.report.theme import MUTED, run_colour
from flexros.validation.campaigns.linearisation.conditions import EXACT
from flexros.validation.campaigns.linearisation.laws import LAWS
from flexros.validation.campaigns.linearisation.settings import TUNINGS

if TYPE_CHECKING:
    from flexros.validation.campaigns.linearisation.conditions import Condition
    from flexros.validation.campaigns.linearisation.figures import Results
    from flexros.validation.campaigns.linearisation.laws import Law

_KINDS = (
    ("model error", "model error [%]", "error", 100.0),
    ("payload", "payload error [%]", "payload", 100.0),
    ("Coulomb friction", "Coulomb friction [% of the torque]", "coulomb", 100.0),
    ("delay", "delay [ms]", "delay", 1e3),
    ("encoder noise", "noise of the encoders [factor]", "noise", 1.0),
    ("sample time", "sample time [ms]", "sample_time", 1e3),
)
_HIDDEN = 1e4


def pictures(results: Results) -> dict[str, Drawing]:
    """Draw the pictures of every robot.

    Args:
        results: All runs.

    Returns:
        Pictures by name: largest tracking error, and largest deflection after the step of the force, of each robot.
    """
    drawn = {}
    for robot in results.settings.robots:
        if TUNINGS[0] in results.settings.tunings:
            drawn[f"tracking_{robot.name}"] = _drawing(results, robot.name, "track")
            drawn[f"force_{robot.name}"] = _drawing(results, robot.name, "push")
    return drawn


def _drawing(results: Results, robot: str, key: str) -> Drawing:
    laws = results.laws(robot, TUNINGS[0])
    panels = []
    for group, label, attribute, unit in _KINDS:
        chosen = [EXACT, *(each for each in results.settings.conditions if each.group == group)]
        chosen.sort(key=lambda each: getattr(each, attribute))
        if len(chosen) < 3:
            continue
        panels.append(_panel(results, robot, key, label, chosen, attribute, unit, laws))
    legend = tuple((law.name, _colour(law)) for law in laws)
    return Drawing(tuple(panels), min(3, max(len(panels), 1)), width=250, height=190, legend=legend)


def _panel(
    results: Results,
    robot: str,
    key: str,
    title: str,
    conditions: list[Condition],
    attribute: str,
    unit: float,
    laws: tuple[Law, ...],
) -> Panel:
    x = np.array([unit * getattr(each, attribute) for each in conditions])
    items: list[Line | Band] = []
    low, high = np.inf, 0.0
    for law in laws:
        figures = [results.figure(robot, TUNINGS[0], law.name, each.name, key) for each in conditions]
        y = np.array([figure.median if np.isfinite(figure.median) else _HIDDEN for figure in figures])
        seen = y[y < _HIDDEN]
        if len(seen):
            low, high = min(low, float(np.min(seen))), max(high, float(np.max(seen)))
        items.append(Line(x, y, _colour(law), 1.8))
    if not np.isfinite(low) or high <= 0.0:
        low, high = 1.0, 10.0
    logarithmic = attribute in ("noise", "sample_time")
    return Panel(title, (float(x[0]), float(x[-1])), (low / 1.5, high * 1.5), tuple(items), x_log=logarithmic)


def _colour(law: Law) -> str:
    """Return the colour of a law, the same in all pictures; the first one, the simplest, is grey."""
    place = LAWS.index(law)
    return run_colour(place - 1) if place else MUTED
