"""Check for inverted torques or positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

CLEAR = 0.5
"""Agreement of the inverted torque with the inverse-dynamics torque above which a sign is wrong (chosen)."""


class Sign(AbstractCheck):
    """An inverted torque or position gives the inverse-dynamics torque the opposite sign at all frequencies."""

    name: ClassVar[str] = "sign"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Find negative factors between torque and inverse-dynamics torque."""
        if checked.order_is_wrong or checked.wrongly_assigned:
            return ()
        inverted = [
            checked.robot.joint_names[motor]
            for motor, fit in enumerate(checked.own)
            if fit is not None and fit.factor < 0 and fit.agreement > CLEAR
        ]
        if not inverted:
            return ()
        text = (
            f"torque and motion of {', '.join(inverted)} have opposite directions compared with robot "
            f"{checked.robot.name}: the sign of torque or encoder is inverted; correct it (sign: -1) when importing"
        )
        return (Finding(text, hopeless=True),)
