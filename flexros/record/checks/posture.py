"""Check for a base that is mounted otherwise than stated, and for zeros of joints elsewhere."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord


class PostureCheck(AbstractCheck):
    """The weight in the torques shows which way gravity acts in the frame of the base, and from where joints count."""

    name: ClassVar[str] = "posture"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Tell another direction of gravity or other zeros that explain far more of the torques."""
        if not checked.postures or checked.wrongly_assigned:
            return ()
        best, names = checked.postures[0], checked.robot.joint_names
        carrying = ", ".join(name for name, carries in zip(names, best.carrying, strict=True) if carries)
        text = (
            f"the weight in the torques of {carrying} is that of robot {checked.robot.name} in another posture: as "
            f"stated {best.stated:.0%} of them are left, and {best.rest:.0%} with "
            f"{' or '.join(posture.told(names) for posture in checked.postures)}. Correct that, or give the right robot"
        )
        return (Finding(text, hopeless=True),)
