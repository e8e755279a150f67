"""Encoders with another zero than the model, by the torques of a log: the weight of the arm is turned."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.encoders.encoder_offset import EncoderOffset
from flexros.gap.fit.torques.missing_load import lowered

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.gap.fit.torques.solution import TorqueRegression
    from flexros.gap.settings import TorqueStartSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

    Regress = Callable[..., TorqueRegression | None]

ROUNDS = 3
"""Solutions around the offsets of the one before (chosen): errors fall quadratically from a tenth of a radian."""


def with_zeros(
    regress: Regress,
    without: TorqueRegression,
    robot: Robot,
    record: Record,
    settings: TorqueStartSettings,
    *,
    rough: bool = False,
) -> TorqueRegression | None:
    """Return the regression with offsets of those encoders whose torques ask for one; None for none.

    One motor after the other gets an offset, the one that lowers most of what is left, for as long as that is by
    `settings.turned`, or by `settings.explained_by_load` where bodies are known roughly: what they leave is as much
    like a turned weight as like anything. Then the torques are taken around these offsets.

    Args:
        regress: The regression of the log.
        without: It without offsets.
        robot: The nominal robot.
        record: The log.
        settings: Settings of the regressions.
        rough: Whether bodies of the robot file are far beyond their tolerance.
    """
    least = settings.explained_by_load if rough else settings.turned
    if robot.commands != "torque" or record.simulated:
        return None
    sought = EncoderOffset()
    left = [
        motor
        for motor, name in enumerate(robot.joint_names)
        if motor not in record.prescribed and sought.sought(robot, name)
    ]
    best = without
    together = regress(zeros=dict.fromkeys(left, 0.0)) if left else None
    if together is None or lowered(without, together, settings) < least:
        return None
    while left:
        tried = [(regress(zeros=dict.fromkeys([*best.zeros, motor], 0.0)), motor) for motor in left]
        found = [(lowered(best, one, settings), one, motor) for one, motor in tried if one is not None]
        share, one, motor = max(found, key=lambda entry: entry[0], default=(0.0, best, -1))
        if share < least:
            break
        best = one
        left.remove(motor)
    for _ in range(ROUNDS * bool(best.zeros)):
        again, before = regress(zeros=best.zeros), best
        if again is None:
            break
        best = again
        if np.allclose(list(best.zeros.values()), list(before.zeros.values()), rtol=0, atol=1e-5):
            break
    return best if best.zeros and lowered(without, best, settings) >= least else None
