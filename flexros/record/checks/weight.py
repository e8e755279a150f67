"""Check for torques without the weight of the arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.balance.joint_assignments import WEIGHTLESS
from flexros.record.balance.regression import coefficients
from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.record.checks.checked_record import CheckedRecord

CARRIES = 0.5
"""Change of the weight that a motor carries over its torque, both rms without their means, from which the weight shows
in it (chosen)."""

FEWEST = 2
"""Fewest motors that carry weight (chosen): at one of them a spring may balance it."""

SHARE = 0.15
"""Largest share of the weight that the torques of these motors together contain [1] (chosen): those of measured arms
contain 0.74 and more of it, and those of an arm whose file states masses three times too large a third."""

LESS, LEFT = 0.5, 0.7
"""Largest rest of these torques together without the weight, over that with it, so that the share is clear, and over
the torques, so that most of their power is known; rms (chosen). A motor of little torque may leave more of it."""


class Weight(AbstractCheck):
    """Controllers that add the weight of the arm beside the torques that they state leave it out of a log."""

    name: ClassVar[str] = "weight"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Compare what the torques leave with and without weight, friction, rotors and offsets fitted."""
        record, robot = checked.record, checked.robot
        if not any(robot.spec.gravity.value) or checked.balance is None or checked.order_is_wrong:
            return ()
        unloaded = checked.torque_without(WEIGHTLESS)[record.valid]
        weight = checked.rigid_torque()[record.valid] - unloaded
        torque = record.torque[record.valid]
        carrying = np.flatnonzero((np.std(weight, axis=0) > CARRIES * np.std(torque, axis=0)) & checked.moves)
        if len(carrying) < FEWEST:
            return ()
        without, weight = (_beside_motor(checked, one, carrying) for one in (torque - unloaded, weight))
        stated = without - weight
        if np.any(np.std(without, axis=0) >= np.std(stated, axis=0)):  # a spring may balance the weight of the others
            return ()
        size = np.linalg.norm(np.std(torque[:, carrying], axis=0))
        left, left_with = np.linalg.norm(without.std(axis=0)), np.linalg.norm(stated.std(axis=0))
        share = np.sum(without * weight) / np.sum(weight**2)
        if not (abs(share) < SHARE and left < min(LESS * left_with, LEFT * size)):
            return ()
        names = ", ".join(robot.joint_names[motor] for motor in carrying)
        text = (
            f"the torques of {names} lack the weight of robot {robot.name}: without it {left / size:.0%} of them is "
            f"left, with it {left_with / size:.0%}. The controller adds the weight to these torques: give "
            "'gravity: [0, 0, 0]' in the robot file, or map torques that contain it"
        )
        return (Finding(text, hopeless=True, like_parameters=True),)


def _beside_motor(checked: CheckedRecord, torques: FloatArray, motors: IntArray) -> FloatArray:
    """Return what an offset, friction and a rotor of some motors leave of torques at them.

    Args:
        checked: The record.
        torques: Torques at all motors [Nm or N], shape (n, M).
        motors: Numbers of k motors, shape (k,).

    Returns:
        Rests [Nm or N], shape (n, k).
    """
    _, speed, acceleration = checked.motion[:, checked.record.valid]
    rests = []
    for motor in motors:
        own, torque = speed[:, motor], torques[:, motor]
        regressors = np.column_stack([np.ones_like(own), own, np.sign(own), acceleration[:, motor]])
        rests.append(torque - regressors @ coefficients(regressors, torque))
    return np.column_stack(rests)
