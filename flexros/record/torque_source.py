"""What drove the robot of a log: commanded or measured torques, or positions that servos follow."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.logs.time_series import JointSeries, Log

TorqueSource = Literal["command", "measured"]
"""Which torque counts as the one that acted: that of joint_commands, or the effort of joint_states."""


def torque_source(
    log: Log,
    wanted: TorqueSource,
    columns: Sequence[int],
    name: str,
    warnings: list[str],
    *,
    may_lack: bool = False,
) -> TorqueSource:
    """Choose the torque of a log: the wanted one, or the other one where only that was recorded of all motors.

    Args:
        log: The log.
        wanted: Torque that is taken where both were recorded.
        columns: Column of each motor in joint_states, length M.
        name: Name of the log, for messages.
        warnings: Receives a sentence where the other one is taken.
        may_lack: Whether measured torques of some motors alone do, where none were commanded.

    Returns:
        The torque that was recorded.

    Raises:
        InputError: No torque was recorded, or that of some motors alone.
    """
    commands, states = log.joint_commands, log.joint_states
    commanded = commands is not None and commands.effort is not None
    effort = states.effort
    known = {states.names[i]: effort is not None and bool(np.isfinite(effort[:, i]).any()) for i in columns}
    measured = all(known.values()) or (may_lack and not commanded and any(known.values()))
    lacking = ", ".join(joint for joint, is_known in known.items() if not is_known)
    if not commanded and any(known.values()) and not measured:
        raise InputError(
            f"{name}: joint_states has no measured torque (effort) of {lacking}, and there are no commanded torques "
            "(effort of joint_commands); record one of them for all motors"
        )
    if not commanded and not measured:
        raise InputError(
            f"{name} has neither commanded torques (effort of joint_commands) nor measured ones (effort of "
            "joint_states); record one of them"
        )
    if wanted == "command" and not commanded:
        warnings.append("the log has no joint_commands; the measured torques of joint_states are used")
        return "measured"
    if wanted == "measured" and not measured:
        warnings.append(f"joint_states has no measured torques (effort) of {lacking}; the commanded torques are used")
        return "command"
    return wanted


def has_torques(log: Log) -> bool:
    """Whether torques were recorded, commanded or measured."""
    commands, states = log.joint_commands, log.joint_states
    commanded = commands is not None and commands.effort is not None and bool(np.any(np.isfinite(commands.effort)))
    return commanded or (states.effort is not None and bool(np.any(np.isfinite(states.effort))))


def position_commands(log: Log) -> tuple[str, JointSeries | None]:
    """Return the topic and the series of the commanded positions: joint_commands, else joint_reference."""
    for topic, series in (("joint_commands", log.joint_commands), ("joint_reference", log.joint_reference)):
        if series is not None and series.position is not None and np.any(np.isfinite(series.position)):
            return topic, series
    return "joint_commands", None


def has_position_commands(log: Log) -> bool:
    """Whether a log has position commands and no torques, so that servos are part of its model."""
    return not has_torques(log) and position_commands(log)[1] is not None
