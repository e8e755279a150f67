"""Check for torques without the weight of the arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.balance.joint_assignments import WEIGHTLESS
from flexros.record.balance.regression import coefficients
from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.checks.checked_record import SLOW

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.checks.checked_record import CheckedRecord

CARRIES = 0.5
"""Change of the weight that a motor carries over its torque, both rms without their means, from which the weight shows
in it (chosen)."""

FEWEST = 2
"""Fewest motors that carry weight (chosen): at one of them a spring may balance it."""

LESS, LEFT = 0.5, 0.5
"""Largest rest of a torque without the weight, over that with it and over the torque, both rms, at each of these motors
(chosen): what a robot file lacks of masses leaves more."""


class Weight(AbstractCheck):
    """Controllers that add the weight of the arm beside the torques that they state leave it out of a log."""

    name: ClassVar[str] = "weight"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Compare what the torques leave with and without weight, friction, rotors and offsets fitted."""
        record, robot = checked.record, checked.robot
        if not any(robot.spec.gravity.value) or checked.balance is None or checked.order_is_wrong:
            return ()
        weightless = robot.with_values(WEIGHTLESS)
        unloaded = rigid_inverse_dynamics(weightless, checked.position, record.sample_time, SLOW)
        with_weight, without = checked.rigid_torque()[record.valid], unloaded[record.valid]
        size = np.maximum(np.std(record.torque[record.valid], axis=0), 1e-300)
        carrying = (np.std(with_weight - without, axis=0) > CARRIES * size) & checked.moves
        if carrying.sum() < FEWEST:
            return ()
        stated, compensated = (_rest(checked, one)[carrying] / size[carrying] for one in (with_weight, without))
        if not np.all((compensated < LESS * stated) & (compensated < LEFT)):
            return ()
        names = ", ".join(name for name, one in zip(robot.joint_names, carrying, strict=True) if one)
        text = (
            f"the torque of {names} lacks the weight of robot {robot.name}: without it {compensated.max():.0%} of the "
            f"torque is left at most, with it {stated.min():.0%} and more. The controller adds the weight to these "
            "torques: give 'gravity: [0, 0, 0]' in the robot file, or map torques that contain it"
        )
        return (Finding(text, hopeless=True, like_parameters=True),)


def _rest(checked: CheckedRecord, arm: FloatArray) -> FloatArray:
    """Return what is left of each torque beside that of the arm, friction, a rotor and an offset: rms, shape (M,)."""
    valid, motors = checked.record.valid, range(checked.robot.n_motors)
    _, speed, acceleration = checked.motion[:, valid]
    other = checked.record.torque[valid] - arm
    rests = np.zeros(len(motors))
    for motor in motors:
        own = speed[:, motor]
        regressors = np.column_stack([np.ones_like(own), own, np.sign(own), acceleration[:, motor]])
        rests[motor] = np.std(other[:, motor] - regressors @ coefficients(regressors, other[:, motor]))
    return rests
