"""Read a log for a diagnosis: an even, checked record, with the periodic parts of its experiment."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.identify.log_record import log_record
from flexros.scenario.recorded_experiment import with_recorded_parts

if TYPE_CHECKING:
    from collections.abc import Collection

    from flexros.logs.time_series import Log
    from flexros.record.record import Record
    from flexros.record.topic_reader import TorqueSource
    from flexros.robot import Robot

UNKNOWN_ORIGIN = (
    "nothing says where the log comes from, so that it counts as that of a simulation, whose torques are exact; import "
    "that of a real machine (flexros import), which states what is assumed of it"
)
"""Warning for a log with neither a scenario of this program nor an import in its provenance."""


def checked_log(
    log: Log,
    robot: Robot,
    *,
    name: str,
    torque: TorqueSource = "command",
    prescribed: Collection[str] = (),
    held_out: bool = False,
) -> Record:
    """Read a log, and check its record for wrong units, signs, joint order and clipping.

    Args:
        log: The log.
        robot: The nominal robot.
        name: Name of the log, for messages.
        torque: Torque that is taken where both were recorded; the other one is taken where it alone was.
        prescribed: Motors whose measured motion drives the model. So it does where no torque of a motor was recorded,
            and on a real machine where a torque has nothing to do with the motion or a joint stands still.
        held_out: Whether the log is only predicted, beside one that is fitted: what stands still in it may move there,
            and is predicted as there.

    Returns:
        The record, of a very fast recorder at a lower rate; its warnings state what was repaired or is doubtful.

    Raises:
        InputError: There is no usable position or torque, or a check rejects the log.
    """
    record = log_record(
        log,
        robot,
        name=name,
        torque=torque,
        positions=True,
        parameters_known=True,
        prescribed=prescribed,
        standing_counts=held_out,
    )
    if not record.imported and not record.simulated:
        record = replace(record, warnings=(*record.warnings, UNKNOWN_ORIGIN))
    return with_recorded_parts(record, log)
