"""A recorded run followed by a blind plant: the law that repeats its commands, and the correction by its positions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, TypeAlias

import casadi as ca
import numpy as np

from flexros.arrays import FloatArray
from flexros.control.base import AbstractControlLaw
from flexros.robot import Robot

if TYPE_CHECKING:
    from flexros.control.context import LoopContext

Correction: TypeAlias = Callable[[Robot], FloatArray]
"""Gives for the simulated robot the gain of the correction of its coordinates and rates, shape (2 n_coordinates, M)."""


class Replay(AbstractControlLaw):
    """Commands that were recorded: they come as the feedforward torque of the reference."""

    kind: ClassVar[str] = "replay"

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states: none."""
        del context
        return 0

    def gain_names(self, context: LoopContext) -> tuple[str, ...]:
        """Return the names of gains: none."""
        del context
        return ()

    def gains(self, context: LoopContext) -> FloatArray:
        """Return the gains, shape (0,)."""
        del context
        return np.zeros(0)

    def function(self, context: LoopContext) -> ca.Function:
        """Build the update `(c, r, y, g) -> (u, c_next)`."""
        c, g = ca.SX.sym("c", 0), ca.SX.sym("g", 0)
        r, y = ca.SX.sym("r", context.references.size), ca.SX.sym("y", context.measurements.size)
        return ca.Function("replay", [c, r, y, g], [context.references.part(r, "feedforward_torque"), c])


def corrected(loop: ca.Function, gain: FloatArray, n_motors: int, reference: slice) -> ca.Function:
    """Add to a loop at the fine rate the correction of its plant by recorded positions.

    Args:
        loop: (c, r, y, g) -> (u, c_next); the first state counts the ticks of a sample, the second M outputs are the
            encoder values of the simulated robot.
        gain: Gain K, shape (2 n_coordinates, M).
        n_motors: Number of motors M.
        reference: Rows of r with the recorded positions.

    Returns:
        The same with K (recorded - simulated) behind u at the first tick of a sample, zeros at the others.
    """
    c, r = ca.SX.sym("c", loop.numel_in(0)), ca.SX.sym("r", loop.numel_in(1))
    y, g = ca.SX.sym("y", loop.numel_in(2)), ca.SX.sym("g", loop.numel_in(3))
    out, after = loop(c, r, y, g)
    missed = r[reference] - out[n_motors : 2 * n_motors]
    push = ca.if_else(c[0] < 0.5, ca.DM(gain) @ missed, 0)
    wide = ca.vertcat(y, ca.SX.sym("unused", gain.shape[0]))
    return ca.Function("corrected", [c, r, wide, g], [ca.vertcat(out, push), after], {"cse": True})
