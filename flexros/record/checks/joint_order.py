"""Check for joints swapped between torques and positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord


class JointOrder(AbstractCheck):
    """Swapped torques are explained by the motions of other motors."""

    name: ClassVar[str] = "joint_order"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Explain all torques by all motions."""
        names = checked.robot.joint_names
        if checked.order_is_wrong:
            pairs = ", ".join(
                f"the torque called {names[torque]} belongs to the motion of {names[motion]}"
                for torque, motion in enumerate(checked.order)
                if torque != motion
            )
            text = f"joints are swapped between torques and positions: {pairs}; correct the names when importing"
            return (Finding(text, hopeless=True),)
        return ()
