"""What the checks of a record share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.gap.record import GapRecord
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class CheckedRecord:
    """A record that is looked at.

    Attributes:
        record: The record.
        robot: The nominal robot.
    """

    record: GapRecord
    robot: Robot
