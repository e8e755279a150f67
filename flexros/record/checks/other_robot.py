"""Check for a log of another robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.arrays import BoolArray
    from flexros.record.checks.checked_record import CheckedRecord

LEAST = 0.3
"""Agreement of torque and inverse-dynamics torque below which a robot explains little (chosen)."""

MOSTLY = 0.6
"""Agreement of the same over the whole motion from which a robot explains most of a torque (chosen)."""

MISSING = 0.2
"""Torque of a motor over that of the rigid arm, both rms, below which it is not the torque of that motion (chosen)."""


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
        if checked.order_is_wrong or checked.assignment or checked.postures or checked.fits_nominal_rate:
            return ()
        unlike = np.array([fit is not None and fit.as_is < LEAST for fit in checked.own])
        if not np.any(unlike):
            return ()
        agreement, size = checked.over_all
        missing = unlike & (size < MISSING)
        findings = []
        if np.any(missing):
            text = (
                f"the torque of {_named(checked, missing)} is less than {MISSING:.0%} of what the bodies of robot "
                f"{checked.robot.name} need for this motion: it was not measured there, weight was subtracted, its "
                "unit is another one, or it is another robot; predictions run away there and hide other causes"
            )
            findings.append(Finding(text, hopeless=False, of_model=True))
        foreign = _named(checked, unlike & ~missing & (agreement < MOSTLY))
        if not foreign:
            return tuple(findings)
        text = (
            f"robot {checked.robot.name} explains little of the torque of {foreign}, as a model without "
            "friction or with wrong masses, gears or rotors does; where a repaired model closes little of the gap too, "
            "it is another robot, or forces act that are not in the log"
        )
        return (*findings, Finding(text, hopeless=False, of_model=True))


def _named(checked: CheckedRecord, marked: BoolArray) -> str:
    """Return the names of the marked motors."""
    return ", ".join(name for name, one in zip(checked.robot.joint_names, marked, strict=True) if one)
