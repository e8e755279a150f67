"""Encoders with another zero than the model, or a base at a slant: the torques of a log show that weight is turned."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.base_tilt import BaseTilt
from flexros.effects.encoders.encoder_offset import EncoderOffset
from flexros.gap.fit.torques.missing_load import lowered
from flexros.gap.fit.torques.solution import rest_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.gap.fit.torques.solution import TorqueRegression
    from flexros.gap.settings import TorqueStartSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

    Regress = Callable[..., TorqueRegression | None]

ROUNDS = 3
"""Solutions around the angles of the one before (chosen): errors fall quadratically from a tenth of a radian."""


def with_turned_weight(
    regress: Regress,
    without: TorqueRegression,
    robot: Robot,
    record: Record,
    settings: TorqueStartSettings,
    *,
    rough: bool = False,
) -> TorqueRegression | None:
    """Return the regression with the encoder offsets, or the slant of the base, that torques ask for; None for none.

    One motor after the other gets an offset, the one that lowers most of what is left, for as long as that is by
    `settings.turned`, or by `settings.explained_by_load` where bodies are known roughly: what they leave is as much
    like a turned weight as like anything. The same is done beside a slant of the base that lowers it by as much for
    each of its angles. Of the two the one with fewer angles stands, unless the other leaves less by as much for each
    further one. Then the torques are taken around these angles.

    Args:
        regress: The regression of the log.
        without: It without either.
        robot: The nominal robot.
        record: The log.
        settings: Settings of the regressions.
        rough: Whether bodies of the robot file are far beyond their tolerance.
    """
    least = settings.explained_by_load if rough else settings.turned
    if robot.commands != "torque" or record.simulated:
        return None
    sought = EncoderOffset()
    motors = [
        motor
        for motor, name in enumerate(robot.joint_names)
        if motor not in record.prescribed and sought.sought(robot, name)
    ]
    tilt = dict.fromkeys(() if robot.flexible_motors else BaseTilt().fitted(robot, "base"), 0.0)
    together = regress(zeros=dict.fromkeys(motors, 0.0), tilt=tilt) if motors or tilt else None
    if together is None or lowered(without, together, settings) < least:
        return None
    best = _with_zeros(regress, without, motors, least, settings)
    tilted = regress(tilt=tilt) if tilt else None
    if tilted is not None and lowered(without, tilted, settings) >= least ** len(tilt):
        beside = _with_zeros(regress, tilted, motors, least, settings)
        few, many = sorted((best, beside), key=lambda one: (_angles(one), rest_of(one)))
        further = max(1, _angles(many) - _angles(few))
        best = many if lowered(few, many, settings) >= least**further else few
    for _ in range(ROUNDS * bool(_angles(best))):
        again, before = regress(zeros=best.zeros, tilt=best.tilt), best
        if again is None:
            break
        best = again
        pairs = ((best.zeros, before.zeros), (best.tilt, before.tilt))
        if all(np.allclose(list(now.values()), list(then.values()), rtol=0, atol=1e-5) for now, then in pairs):
            break
    # under the right gravity a model that is right otherwise leaves little, and a small part of it is no measure
    judged = replace(best, left=best.rest * without.left / without.rest) if best.tilt else best
    return best if _angles(best) and lowered(without, judged, settings) >= least else None


def _with_zeros(
    regress: Regress, best: TorqueRegression, motors: Sequence[int], least: float, settings: TorqueStartSettings
) -> TorqueRegression:
    """Return a regression with offsets of those encoders that lower by enough what it leaves.

    Args:
        regress: The regression of the log.
        best: It without offsets.
        motors: Motors whose encoders may have one.
        least: Least factor by which each one lowers what is left [1].
        settings: Settings of the regressions.
    """
    left, tilt = list(motors), dict.fromkeys(best.tilt, 0.0)
    while left:
        tried = [(regress(zeros=dict.fromkeys([*best.zeros, motor], 0.0), tilt=tilt), motor) for motor in left]
        found = [(lowered(best, one, settings), one, motor) for one, motor in tried if one is not None]
        share, one, motor = max(found, key=lambda entry: entry[0], default=(0.0, best, -1))
        if share < least:
            break
        best = one
        left.remove(motor)
    return best


def _angles(regression: TorqueRegression) -> int:
    """Return the number of angles by which a regression turns weight."""
    return len(regression.zeros) + len(regression.tilt)
