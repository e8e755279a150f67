"""Robots and their linear models."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.robot.linear.linearise import LinearModel
from flexros.robot.linear.linearise import linear_model as linearised
from flexros.workbench.given import robot_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from flexros.workbench.given import GivenModel


def linear_model(model: GivenModel, q: ArrayLike | None = None, *, output: str | None = None) -> LinearModel:
    """Linearise a robot at rest: M dq'' + D dq' + K dq = B du (Moberg 2007, Paper B, section 3.2).

    Args:
        model: Built-in name, path of a robot file or of a patch, or a robot. Effects that are no part of a linear
            model, such as friction, are omitted.
        q: Arm coordinates of the pose [rad or m], shape (N,); default: the home pose.
        output: Name of the controlled output; default: that of the robot file.

    Returns:
        The linear model: `to_control()` gives a `control.StateSpace` from motor torques to motor positions and output,
        `to_pandas()` its modes, `plot()` its Bode picture.

    Raises:
        InputError: Unknown robot, invalid pose, unknown output, or no equilibrium.
    """
    return linearised(robot_of(model), q, output)
