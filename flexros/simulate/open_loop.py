"""The open loop: a controller without feedback."""

from __future__ import annotations

import casadi


def feed_through(n_motors: int, n_further: int = 0) -> casadi.Function:
    """Build the update (c, r, y, g) -> (u, c_next), without state and gains, that commands the feedforward torque.

    Args:
        n_motors: Number of motors, M.
        n_further: Number of values of further sensors.
    """
    c, g = casadi.SX.sym("c", 0), casadi.SX.sym("g", 0)
    r, y = casadi.SX.sym("r", 3 * n_motors), casadi.SX.sym("y", n_motors + n_further)
    return casadi.Function("feed_through", [c, r, y, g], [r[2 * n_motors :], c], ["c", "r", "y", "g"], ["u", "c_next"])
