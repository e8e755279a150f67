"""Check for a log of another robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.arrays import BoolArray
    from flexros.record.checks.checked_record import CheckedRecord

LEAST = 0.3
"""Agreement of torque and inverse-dynamics torque below which a robot explains little (chosen)."""

MOSTLY = 0.6
"""Agreement of the same over the whole motion from which a robot explains most of a torque (chosen)."""

SLOW = 4.0
"""Frequency up to which that agreement needs the motion [Hz] (chosen): weight and slow moves."""


class OtherRobot(AbstractCheck):
    """Torques unlike the inverse-dynamics torques: a model to be repaired, another robot, or unknown forces."""

    name: ClassVar[str] = "other_robot"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Find motors whose torque is unlike the inverse-dynamics torque."""
        if checked.balance is None:
            text = (
                f"robot {checked.robot.name} has no equilibrium near the positions of the log, so torques and motions "
                "were not compared; check units and zeros of the encoders, or give the right robot"
            )
            return (Finding(text, hopeless=False),)
        if checked.order_is_wrong or checked.assignment or checked.fits_nominal_rate:
            return ()
        unlike = np.array([fit is not None and fit.as_is < LEAST for fit in checked.own])
        if np.any(unlike):
            unlike &= ~_mostly_explained(checked)
        foreign = [name for name, one in zip(checked.robot.joint_names, unlike, strict=True) if one]
        if not foreign:
            return ()
        text = (
            f"robot {checked.robot.name} explains little of the torque of {', '.join(foreign)}, as a model without "
            "friction or with wrong masses, gears or rotors does; where a repaired model closes little of the gap too, "
            "it is another robot, or forces act that are not in the log"
        )
        return (Finding(text, hopeless=False, of_model=True),)


def _mostly_explained(checked: CheckedRecord) -> BoolArray:
    """Return whose torque is mostly that of the rigid arm over the whole motion, shape (M,).

    The spectra begin at several periods of a stretch, and every half octave counts alike. In a slow motion the weight
    is below them, and what is left is noise of the torque.
    """
    record = checked.record
    torque = rigid_inverse_dynamics(checked.robot, checked.position, record.sample_time, SLOW)
    needed, given = (part[record.valid] - part[record.valid].mean(axis=0) for part in (torque, record.torque))
    power = np.sum(needed**2 + given**2, axis=0)
    agreement = 2 * np.sum(needed * given, axis=0) / np.maximum(power, np.finfo(float).tiny)
    return np.asarray(agreement > MOSTLY)
