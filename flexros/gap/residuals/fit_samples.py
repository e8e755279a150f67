"""Samples of a log that are fitted: of a long one fewer, at a lower rate or of its most informative part."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.record.most_informative import most_informative
from flexros.record.resampled import with_fewer_samples

if TYPE_CHECKING:
    from flexros.gap.settings import DiagnosisSettings
    from flexros.record.record import Record
    from flexros.robot import Robot


PIECES, LENGTH = 3, 0.1
"""Pieces of the rest of a log that are looked at, and the length of each over that of the part that is used [1]
(chosen): together they take as long as a few predictions of that part."""


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


def pieces_of_rest(log: Record, used: Record) -> tuple[Record, ...]:
    """Cut pieces out of what is not used of a log, spread over all of it.

    Args:
        log: The log.
        used: The part of it that is used.

    Returns:
        The pieces; none where the rest is shorter than one.
    """
    first, length = round((used.begin - log.begin) / log.sample_time), int(LENGTH * used.n_samples)
    before = np.arange(0, first - length + 1, max(length, 1))
    behind = np.arange(first + used.n_samples, log.n_samples - length + 1, max(length, 1))
    starts = np.concatenate([before, behind])
    if not len(starts):
        return ()
    chosen = np.unique(np.linspace(0, len(starts) - 1, PIECES).round().astype(int))
    return tuple(log.part(begin, begin + length) for begin in starts[chosen].tolist())


def _rigid(record: Record, robot: Robot) -> bool:
    """Return whether torques move a rigid arm, and tolerances make the floor, which more samples do not lower."""
    return robot.is_rigid and record.command is None and not record.premises.floor_is_noise
