"""Loops of small robots for tests of control laws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.control.context import LoopContext
from flexros.robot.robot import robot_from_data

if TYPE_CHECKING:
    from collections.abc import Sequence


def loop_context(n_motors: int, sample_time: float, limits: Sequence[float] | None = None) -> LoopContext:
    """Build the loop of a chain of stiff joints; torque limits [Nm] of shape (n_motors,), infinite for none."""
    bodies = []
    for limit in limits or [np.inf] * n_motors:
        motor = {"inertia": 1.0} | ({"torque_limit": limit} if np.isfinite(limit) else {})
        bodies.append(
            {"inertia": {"zz": 1.0}, "length": [1, 0, 0], "directions": {"rz": {"spring": "rigid", "motor": motor}}}
        )
    names = [f"body_{number + 1}.rz" for number in range(n_motors)]
    data = {"name": "chain", "bodies": bodies, "outputs": {"joints": {"coordinates": names}}, "controlled": "joints"}
    return LoopContext(robot_from_data(data, "test"), sample_time)
