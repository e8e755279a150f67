"""The open loop: a controller that commands the feedforward torque alone."""

from __future__ import annotations

import casadi


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
