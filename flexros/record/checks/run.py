"""Run all checks of a record, stage by stage: hopeless logs are rejected, doubtful ones get warnings."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.logs.reader import give_memory_back
from flexros.record.checks.base import Finding, checks
from flexros.record.checks.checked_record import CheckedRecord
from flexros.record.prescribed_motion import without_prescribed

if TYPE_CHECKING:
    from flexros.record.record import Record
    from flexros.robot import Robot


LONG = 100_000
"""Positions of a log from which the memory of temporary arrays is given back after each check (chosen)."""

MOST = 3
"""Most reasons, and most warnings of the reader, that a refusal names (chosen)."""


def findings(record: Record, robot: Robot) -> tuple[Finding, ...]:
    """Collect the findings of all checks, up to the first stage with a hopeless one.

    Args:
        record: The record.
        robot: The nominal robot.

    Returns:
        Problems, the hopeless ones first.
    """
    checked = CheckedRecord(without_prescribed(record), robot)
    problems: list[Finding] = []
    servos = record.command is not None
    members = [member() for member in checks().values() if not (servos and (member.of_torque or member.stage == 2))]
    for stage in sorted({member.stage for member in members}):
        for member in members:
            if member.stage == stage:
                problems += member.look(checked)
                if record.position.size > LONG:
                    give_memory_back()  # temporary arrays
        if any(finding.hopeless for finding in problems):
            break
    return tuple(sorted(problems, key=lambda finding: not finding.hopeless))


def check_record(record: Record, robot: Robot, *, parameters_known: bool = True) -> Record:
    """Reject a record that would give wrong results, and warn of what is doubtful.

    Args:
        record: The record.
        robot: The nominal robot.
        parameters_known: Whether the nominal parameters are about right. Identification, which estimates them, says
            False: findings that wrong parameters imitate are warnings then.

    Returns:
        The record with the warnings of the checks. Samples that a check found unusable are not valid any more, and
        those before which the clock jumps are marked.

    Raises:
        InputError: The log is hopeless; the message names the log, the problem, what to do and what its reading found.
    """
    problems = findings(record, robot)
    hopeless = [
        finding.text for finding in problems if finding.hopeless and (parameters_known or not finding.like_parameters)
    ]
    if hopeless:
        reading = f" (in reading it: {'; '.join(record.warnings[:MOST])})" if record.warnings else ""
        raise InputError(f"{record.name}: {'; moreover '.join(hopeless[:MOST])}{reading}")
    valid = record.valid.copy()
    for finding in problems:
        if finding.spoilt is not None:
            valid &= ~finding.spoilt
    jumps = [finding.jumps for finding in problems if finding.jumps is not None]
    return replace(
        record,
        valid=valid,
        jumps=np.sum(jumps, axis=0) if jumps else record.jumps,
        warnings=tuple(dict.fromkeys([*record.warnings, *(finding.text for finding in problems)])),
        doubts=tuple(finding.text for finding in problems if finding.of_model),
        open_doubts=tuple(finding.text for finding in problems if finding.of_either),
    )
