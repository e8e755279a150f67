"""Check for a wrong time base."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord


class TimeBase(AbstractCheck):
    """With a wrong sample time, speeds, accelerations and resonances are wrong."""

    name: ClassVar[str] = "time_base"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Compare the agreement of torques and motions at the nominal sample time with that of the stamps."""
        if not checked.fits_nominal_rate:
            return ()
        record, robot = checked.record, checked.robot
        text = (
            f"the stamps are {1e3 * record.sample_time:.6g} ms apart, but torques and motions fit robot {robot.name} "
            f"far better at its sample time of {1e3 * robot.sample_time:.6g} ms: the time base of the log is wrong; "
            "correct it when importing"
        )
        return (Finding(text, hopeless=True, like_parameters=True),)
