"""Check for commands of which the log holds only every so many."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

THINNED = 1.5
"""Commands of the controller for each one in the log, above which it is thinned (chosen)."""


class ThinnedCommands(AbstractCheck):
    """Torques between recorded commands are not known: held or interpolated, they look like an error of the model."""

    name: ClassVar[str] = "thinned_commands"
    stage: ClassVar[int] = 1
    of_torque: ClassVar[bool] = True

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Compare the rate of the commands with that of the controller, where the log states it."""
        every = checked.record.thinned
        if checked.record.measured_torque or every < THINNED:
            return ()
        text = (
            f"joint_commands holds one of {every:.3g} commands of the controller that the log names, so the torques "
            "between them are not known, and a model would seem to be wrong; record every command, or measured torques"
        )
        return (Finding(text, hopeless=True, like_parameters=True),)
