"""Check for inverted or exchanged joints, by couplings and gravity."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord


class JointAssignmentCheck(AbstractCheck):
    """Couplings and gravity show errors of direction and order that torque and position of one motor do not."""

    name: ClassVar[str] = "joint_assignment"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Try the log with joints inverted and each pair exchanged."""
        if checked.assignment is None or (checked.postures and not checked.assignment.clear):
            return ()
        if not checked.assignment.clear:
            if set(checked.assignment.exchanged) & set(checked.record.prescribed):
                return ()  # a joint without a torque that counts, which nearly any torque fits better
            text = (
                f"torques and motions fit robot {checked.robot.name} badly, and better with {checked.assignment.text} "
                f"(agreement {checked.assignment.agreement:.2f} of 1): check signs and zeros (offset) of the mapping"
            )
            return (Finding(text, hopeless=False),)
        text = (
            f"torques and motions fit robot {checked.robot.name} far better with {checked.assignment.text} (agreement "
            f"{checked.assignment.agreement:.2f} of 1){_or_mounted(checked)}: correct signs, names or zeros (offset) "
            "when importing, or give the right robot"
        )
        return (Finding(text, hopeless=True, like_parameters=not checked.assignment.opposite),)


def _or_mounted(checked: CheckedRecord) -> str:
    """Return how the base may be mounted instead; empty where nothing speaks for it."""
    mounted = [posture.told(checked.robot.joint_names) for posture in checked.postures if not posture.turned.any()]
    return f", or with {mounted[0]}" if mounted else ""
