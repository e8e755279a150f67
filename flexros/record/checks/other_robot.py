"""Check for a log of another robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

LEAST = 0.3
"""Agreement of torque and inverse-dynamics torque below which a robot explains little (chosen)."""


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
        foreign = [
            checked.robot.joint_names[motor]
            for motor, fit in enumerate(checked.own)
            if fit is not None and fit.as_is < LEAST
        ]
        if not foreign:
            return ()
        text = (
            f"robot {checked.robot.name} explains little of the torque of {', '.join(foreign)}, as a model without "
            "friction or with wrong masses, gears or rotors does; where a repaired model closes little of the gap too, "
            "it is another robot, or forces act that are not in the log"
        )
        return (Finding(text, hopeless=False, of_model=True),)
