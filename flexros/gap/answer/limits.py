"""What a log cannot tell, whatever the fit: limits of motor encoder and commanded torque."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.gap.answer.decision import Findings

TESTED = 0.6
"""Share of the torque limit below which a motor has not shown what it does under load [1] (chosen)."""
HIGHEST = 0.4
"""Frequency over the sampling rate up to which a log tells anything [1] (chosen)."""


def cannot_tell(found: Findings) -> tuple[str, ...]:
    """Say what the signals of a log cannot tell.

    Args:
        found: What was found, with log and model.

    Returns:
        Sentences.
    """
    record, robot = found.data.record, found.model.robot
    told = []
    if record.tool is None:
        told.append(
            "The tool was not measured: errors of lengths and angles of the arm (kinematic_error) cannot be seen, and "
            "the motion behind the last motor is known through the motors only."
        )
    if not record.measured_torque:
        told.append(
            "The torque is the commanded one: a wrong torque constant differs from a wrong inertia only through what "
            "does not scale with torque (springs, dampers, friction, gravity)."
        )
    limits = robot.torque_limits
    reached = np.max(np.abs(record.torque), axis=0)
    for name, limit, most in zip(robot.joint_names, limits, reached):
        if np.isfinite(limit) and most < TESTED * limit:
            told.append(
                f"{name} was given at most {100 * most / limit:.0f} % of its torque limit: a saturation above that, "
                "and stiffness at higher loads, are not tested."
            )
    told.append(
        f"Nothing is known above {HIGHEST / record.sample_time:.0f} Hz, and a lag far below "
        f"{record.sample_time * 1e3:g} ms looks like a delay."
    )
    if not np.any(robot.spec.gravity.value):
        told.append("Without gravity, errors of masses and of inertias cannot be told apart.")
    return tuple(told)
