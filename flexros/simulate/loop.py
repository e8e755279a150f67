"""A robot and a control law as the functions of a closed loop."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi

from flexros.compile.loop_functions import LoopFunctions

if TYPE_CHECKING:
    from flexros.robot.model import SymbolicModel


def loop_functions(model: SymbolicModel, controller: casadi.Function) -> LoopFunctions:
    """Put a model and a controller together.

    Args:
        model: Symbolic model of the plant; its free parameters become those of the loop.
        controller: Update (c, r, y, g) -> (u, c_next).

    Returns:
        The functions from which the loop is compiled.
    """
    return LoopFunctions(
        derivative=model.derivative, encoder=model.encoder, tool_pose=model.tool_pose, controller=controller
    )


def feed_through(n_motors: int) -> casadi.Function:
    """Make the controller that commands the feedforward torque alone: an open loop.

    Args:
        n_motors: Number of motors M.

    Returns:
        Update (c, r, y, g) -> (u, c_next) without state and gains.
    """
    c, g = casadi.SX.sym("c", 0), casadi.SX.sym("g", 0)
    r, y = casadi.SX.sym("r", 3 * n_motors), casadi.SX.sym("y", n_motors)
    return casadi.Function("feed_through", [c, r, y, g], [r[2 * n_motors :], c], ["c", "r", "y", "g"], ["u", "c_next"])
