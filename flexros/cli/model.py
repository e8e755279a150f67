"""Models named on the command line: robots, robot files and patches."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from flexros.robot import Robot

ROBOT = "Shipped robot, or path of a robot YAML or of a patch.yaml."
"""Help of an option or argument that takes a model."""


def linear_robot(name_or_path: str) -> Robot:
    """Load a model for what works with linear models; says on stderr which effects of a patch have no part in it.

    Args:
        name_or_path: Shipped robot, or path of a robot file or of a patch.

    Returns:
        The robot with the effects that change its model.

    Raises:
        InputError: It cannot be loaded.
    """
    from flexros.effects.patching.patched_robot import load_model

    model = load_model(name_or_path)
    left_out = [law.name for law in model.laws if not law.effect.neutral]
    if left_out:
        typer.echo(
            f"flexros: {name_or_path} holds {', '.join(left_out)}, which {'is' if len(left_out) == 1 else 'are'} no "
            "part of a linear model; here the robot is taken without",
            err=True,
        )
    return model.robot
