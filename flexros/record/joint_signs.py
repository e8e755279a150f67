"""Joints of an imported robot that count the other way round, and that the mapping of a log does not turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.logs.foreign.mapping import LogMapping
from flexros.robot.exchange.joint_names import tagged, turned_round

if TYPE_CHECKING:
    from flexros.logs.time_series import Log
    from flexros.record.record import Record
    from flexros.robot import Robot


def joints_not_turned(log: Log, robot: Robot) -> tuple[str, ...]:
    """List joints that count the other way round than the motors of the robot file, in the log as in their own file.

    Where a servo follows its commands, position and command have the same sign either way: couplings and weight alone
    show it, and seldom.

    Args:
        log: The log; an imported one has its mapping in the provenance.
        robot: The robot; one made from a URDF or an MJCF has tags that say which joints were turned.

    Returns:
        Their names, with those of the motors; empty where the mapping turns all of them, or is not known.
    """
    turned = [motor for motor in robot.joint_names if turned_round(robot, motor)]
    imported = log.provenance.get("import")
    given = imported.get("mapping") if isinstance(imported, dict) else None
    if not turned or not isinstance(given, dict):
        return ()
    try:
        mapping = validate(LogMapping, given, "the mapping in the provenance")
    except InputError:  # a provenance of another version, which the answer does not depend on
        return ()
    as_recorded = {one.joint for one in mapping.columns if one.quantity == "position" and one.factor > 0}
    return tuple(f"{tagged(robot, motor)} ({motor})" for motor in turned if motor in as_recorded)


def sign_words(*records: Record) -> tuple[str, ...]:
    """Say which joints may count the other way round than the robot, where the gap of logs is not explained."""
    names = dict.fromkeys(name for record in records for name in record.not_turned)
    if not names:
        return ()
    return (
        f"the robot file counts {', '.join(names)} the other way round than the file that it was imported from (its "
        "tag joint_sign), and the mapping of the log does not turn them: if the log counts as that file does, import "
        "it again with sign: -1 at all their columns, as flexros import proposes where it is given the model",
    )
