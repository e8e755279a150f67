"""Sensitivity of every law over its bandwidth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError
from flexros.validation.campaigns.linearisation.laws import LAWS, axes_of
from flexros.validation.campaigns.linearisation.robots import Encoders, robot_with
from flexros.validation.campaigns.linearisation.tuning import LinearLoops

if TYPE_CHECKING:
    from flexros.validation.campaigns.linearisation.robots import StudyRobot
    from flexros.validation.campaigns.linearisation.settings import LinearisationSettings

BANDWIDTHS = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 80.0)
"""Bandwidths of the table [rad/s]."""


def robustness_part(settings: LinearisationSettings, robot: StudyRobot) -> dict[str, Any]:
    """Return the largest sensitivity of every law that fits a robot, its second number as usual.

    Args:
        settings: The laws.
        robot: The robot.

    Returns:
        For JSON: `bandwidths` [rad/s], and `sensitivity`, a list for each law; None where the loop is unstable.
    """
    found = {}
    for law in (law for law in LAWS if law.name in settings.laws):
        nominal = robot_with(robot.name, Encoders(law.links))
        loops = LinearLoops(law, nominal, axes_of(nominal), robot.poses, 5e-4)
        try:
            values = [loops.tuning(w, law.first).sensitivity for w in BANDWIDTHS]
        except InputError:
            continue
        found[law.name] = [float(f"{value:.4g}") if np.isfinite(value) else None for value in values]
    return {"bandwidths": list(BANDWIDTHS), "sensitivity": found}
