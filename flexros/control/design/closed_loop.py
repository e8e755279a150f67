"""Sampled closed loops of linear plants and a controller: eigenvalues and stability."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.control.linear_controller import connected

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.design.plants import SampledPlants
    from flexros.control.linear_controller import LinearController


def closed_loops(plants: SampledPlants, controller: LinearController, gain: float = 1.0) -> FloatArray:
    """Close the loop of every plant from its measurements to its commands.

    Args:
        plants: Q sampled plants.
        controller: The controller about rest.
        gain: Factor on the loop gain [1].

    Returns:
        System matrices of the states of plant and controller (those of `connected`), shape (Q, n + m, n + m).
    """
    controller = connected(controller)
    n, m = plants.A.shape[-1], len(controller.state_step)
    loops = np.empty((len(plants), n + m, n + m))
    loops[:, :n, :n] = plants.A + gain * plants.B @ controller.from_measured @ plants.C
    loops[:, :n, n:] = gain * plants.B @ controller.from_state
    loops[:, n:, :n] = controller.state_measured @ plants.C
    loops[:, n:, n:] = controller.state_step
    return loops


def largest_eigenvalues(plants: SampledPlants, controller: LinearController, gain: float = 1.0) -> FloatArray:
    """Return the largest absolute eigenvalue of every closed loop, below 1 where it is stable, shape (Q,)."""
    return np.asarray(np.max(np.abs(np.linalg.eigvals(closed_loops(plants, controller, gain))), axis=-1))
