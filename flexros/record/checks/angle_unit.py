"""Check for positions in degrees."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.checks.degrees import like_degrees
from flexros.record.checks.unit import Unit

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord


class AngleUnit(AbstractCheck):
    """Degrees taken as radians turn the weight of an arm many times round, so that no factor of a unit shows it."""

    name: ClassVar[str] = "angle_unit"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Try angles beyond two turns in degrees."""
        if Unit().look(checked):
            return ()
        text = like_degrees(checked)
        return (Finding(text, hopeless=True),) if text else ()
