"""Samples of a log that are fitted: of a long one fewer, at a lower rate or of its most informative part."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.record.most_informative import most_informative
from flexros.record.resampled import with_fewer_samples

if TYPE_CHECKING:
    from flexros.gap.settings import DiagnosisSettings
    from flexros.record.record import Record
    from flexros.robot import Robot


def at_rate_of_fits(record: Record, robot: Robot, settings: DiagnosisSettings) -> Record:
    """Lower the rate of a real machine's long log of torques where the model has no springs; else return it as it is.

    Args:
        record: The log.
        robot: The nominal robot.
        settings: Settings of the diagnosis.
    """
    if not _rigid(record, robot):
        return record
    rigid = settings.rigid_arm
    return with_fewer_samples(record, rigid.plenty, rigid.lowest_rate, "which suffices for an arm without springs")


def part_of_fits(record: Record, robot: Robot, settings: DiagnosisSettings) -> Record:
    """Cut the most informative part out of a longer log than is fitted.

    Args:
        record: The log, fitted or held out.
        robot: The nominal robot.
        settings: Settings of the diagnosis.
    """
    most = settings.rigid_arm.most_values if _rigid(record, robot) else settings.most_values
    if settings.time_limit is None:
        return most_informative(record, most)
    in_time = max(round(settings.values_per_second * settings.time_limit), settings.least_values)
    return most_informative(record, min(most, in_time), "that there is time for" if in_time < most else "")


def _rigid(record: Record, robot: Robot) -> bool:
    """Return whether torques move a rigid arm, and tolerances make the floor, which more samples do not lower."""
    return robot.is_rigid and record.command is None and not record.premises.floor_is_noise
