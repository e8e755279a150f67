"""Models named on the command line: robots, robot files and patches."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from flexros.errors import FlexrosError

if TYPE_CHECKING:
    from flexros.logs.time_series import Log
    from flexros.robot import Robot

ROBOT = "Built-in robot, or path of a robot YAML or of a patch.yaml."
"""Help of options and arguments for a model."""


def linear_robot(name_or_path: str) -> Robot:
    """Load a model for linear analysis; effects of a patch that it omits are reported on stderr.

    Args:
        name_or_path: Built-in robot, or path of a robot file or of a patch.

    Returns:
        The robot with the effects that change its linear model.

    Raises:
        InputError: It cannot be loaded.
    """
    from flexros.effects.patching.patched_robot import load_model

    model = load_model(name_or_path)
    left_out = [law.name for law in model.laws if not law.effect.neutral]
    if left_out:
        typer.echo(
            f"flexros: {name_or_path} holds {', '.join(left_out)}, which {'is' if len(left_out) == 1 else 'are'} no "
            "part of a linear model and omitted here",
            err=True,
        )
    return model.robot


def robot_of_run(model: str, log: Log) -> Robot | None:
    """Load the robot of a run.

    Args:
        model: Built-in robot, or path of a robot file or of a patch; empty for the one in the provenance of the log.
        log: The log.

    Returns:
        The robot; None where the provenance names none that can be loaded.

    Raises:
        InputError: The given model cannot be loaded.
    """
    from flexros.effects.patching.patched_robot import load_model

    if model:
        return load_model(model).robot
    scenario = log.provenance.get("scenario")
    name = scenario.get("robot") if isinstance(scenario, dict) else None
    try:
        return load_model(name).robot if isinstance(name, str) else None
    except FlexrosError:
        return None
