"""A log as the record that identification and diagnosis take their samples from."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.identify.rigid.torque_timing import with_torque_in_time
from flexros.logs.reader import give_memory_back
from flexros.record.checks.braked import without_braked_rests
from flexros.record.checks.foreign_torque import without_foreign_torque
from flexros.record.checks.run import check_record
from flexros.record.checks.standing_joint import without_standing_joints
from flexros.record.read import read_record
from flexros.record.resampled import at_usual_rate
from flexros.record.torques.torque_noise import without_torque_noise

if TYPE_CHECKING:
    from collections.abc import Collection

    from flexros.logs.time_series import Log
    from flexros.record.record import Record
    from flexros.record.topic_reader import TorqueSource
    from flexros.robot import Robot


def log_record(
    log: Log,
    robot: Robot,
    *,
    name: str,
    torque: TorqueSource = "command",
    positions: bool = False,
    parameters_known: bool = False,
    prescribed: Collection[str] | None = None,
    foreign_counts: bool = False,
    standing_counts: bool = False,
) -> Record:
    """Read and check a log: the record of identification and, with what `gap.checked_log` adds, of a diagnosis.

    When a noted torque acted is found here where rigid links show it clearly. What else a model shows of it
    (`flexros.gap.fit.torques.noted_timing`) diagnosis and gap alone allow for: a torque may act half a sample from
    where `flexros identify` takes it.

    Args:
        log: The log.
        robot: The robot with its nominal parameters.
        name: Name of the log, for messages.
        torque: Torque that is taken where both were recorded; the other one is taken where it alone was.
        positions: Whether a log of position commands without torques is read; see `read_record`.
        parameters_known: Whether the nominal parameters are about right; see `check_record`.
        prescribed: Motors whose measured motion drives the model; so it does where a torque was not recorded or, on a
            real machine, has nothing to do with the motion or the joint stands still. None: no motor's does.
        foreign_counts: Whether a torque that has nothing to do with the motion counts all the same, as where the
            nominal parameters are only a guess.
        standing_counts: Whether the torque of a joint that stands still counts all the same.

    Returns:
        The record of `read_record`, measured torques when they acted and without white noise, of a very fast recorder
        at a lower rate. Samples that a check found unusable are not valid.

    Raises:
        InputError: There is no usable position or torque, or a check rejects the log.
    """
    record = read_record(log, robot, name=name, torque=torque, positions=positions, prescribed=prescribed)
    give_memory_back()
    record = without_braked_rests(record, robot)
    if prescribed is not None and not standing_counts:
        record = without_standing_joints(record, robot)
    if prescribed is not None and not foreign_counts:
        record = without_foreign_torque(record, robot)
    checked = check_record(with_torque_in_time(record, robot), robot, parameters_known=parameters_known)
    give_memory_back()
    return without_torque_noise(at_usual_rate(checked), robot)
