"""Whether torque and motion with the same stamp belong to the same instant."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.gap.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.gap.checked_record import CheckedRecord

BETTER = 0.02
"""Gain in agreement from which an offset is believed (chosen)."""

EARLIEST = 0.6
"""Time in samples by which a motion may lead its torque; no robot does (chosen)."""

LONGEST = 0.01
"""Delay of the torque beyond which an offset between topics is likelier than a delay of the robot [s] (chosen)."""


class TimeOffset(AbstractCheck):
    """A torque stamped later than it acts cannot be explained by any robot; a long delay may be one of the log."""

    name: ClassVar[str] = "time_offset"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Shift the torques in time until they agree best with what the motions need."""
        if checked.order_is_wrong or checked.balance is None:
            return ()
        tau, better = checked.delay
        if better < BETTER:
            return ()
        if tau < -EARLIEST * checked.record.sample_time:
            text = (
                f"the torques are stamped {-1e3 * tau:.2g} ms too late: the motions precede them beside the delay of "
                f"{1e3 * checked.robot.delay:g} ms of the robot file; give time_offset when importing, so that "
                "commands and measurements of the same instant have the same stamp"
            )
            return (Finding(text, hopeless=True),)
        if tau > LONGEST:
            text = (
                f"the torques act {1e3 * tau:.2g} ms later than they are stamped; if that is no delay of the robot, "
                "give time_offset when importing"
            )
            return (Finding(text, hopeless=False),)
        return ()
