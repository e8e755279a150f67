"""Tracking error of the motors, torque against feedforward, saturation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flexros.analysis.elapsed_time import elapsed_seconds
from flexros.analysis.error_statistics import ErrorStatistics, error_statistics
from flexros.errors import InputError
from flexros.logs.time_series import JointSeries

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.time_series import Log

_AT_LIMIT = 1e-9
"""A torque within this relative distance of its limit is limited."""


@dataclass(frozen=True, eq=False)
class MotorTracking:
    """Tracking and torque of one motor; what the log does not hold is None.

    Attributes:
        joint: Name of the joint.
        linear: Whether the motor moves in metres and newtons; radians and newton metres otherwise.
        time: Time of the position samples, from the start of the log [s], shape (n,).
        error: Reference minus measured position [rad, or m for a linear motor], shape (n,).
        tracking: Figures of `error`.
        torque_time: Time of the torque samples, from the start of the log [s], shape (k,).
        torque: Commanded torque [Nm, or N], shape (k,).
        feedforward: Feedforward torque at the same stamps [Nm, or N], shape (k,).
        feedback: `torque` minus `feedforward` [Nm, or N], shape (k,).
        torque_max: Largest absolute commanded torque [Nm, or N].
        feedback_rms: Rms of `feedback` [Nm, or N].
        feedback_share: Rms of `feedback` over rms of `torque`: 0 for pure feedforward, 1 without feedforward; above 1
            where the two oppose each other.
        torque_limit: Torque limit [Nm, or N]; inf where there is none, None where it is not known.
        limited_by: Source of the limit.
        saturated_share: Share of the torque samples at the limit.
        overload_share: Share of the torque samples whose feedforward alone exceeds the limit.
        deflection: Largest absolute difference between link-side encoder and motor, both about their means [rad, or m];
            None without such an encoder.
    """

    joint: str
    linear: bool
    time: FloatArray | None
    error: FloatArray | None
    tracking: ErrorStatistics | None
    torque_time: FloatArray | None
    torque: FloatArray | None
    feedforward: FloatArray | None
    feedback: FloatArray | None
    torque_max: float | None
    feedback_rms: float | None
    feedback_share: float | None
    torque_limit: float | None
    limited_by: str | None
    saturated_share: float | None
    overload_share: float | None
    deflection: float | None = None

    def as_dict(self) -> dict[str, object]:
        """Return the figures as plain numbers: rad and Nm; m and N for a linear motor."""
        return {
            "tracking_error": None if self.tracking is None else self.tracking.as_dict(),
            "torque_max": self.torque_max,
            "feedback_rms": self.feedback_rms,
            "feedback_share": self.feedback_share,
            "torque_limit": self.torque_limit if self.torque_limit is None or np.isfinite(self.torque_limit) else None,
            "torque_limited_by": self.limited_by,
            "saturated_share": self.saturated_share,
            "overload_share": self.overload_share,
            "link_deflection_max": self.deflection,
        }


@dataclass(frozen=True)
class Drive:
    """Known properties of a motor.

    Attributes:
        joint: Name of its joint.
        torque_limit: Largest absolute torque [Nm, or N]; inf where none.
        linear: Whether it moves in metres.
        limited_by: Source of the limit.
    """

    joint: str
    torque_limit: float
    linear: bool = False
    limited_by: str = "robot"


def assign_drives(drives: Sequence[Drive], joints: Sequence[str], warnings: list[str]) -> dict[str, Drive]:
    """Assign the motors of the robot to the joints of the log: by name, by order where the names differ.

    Args:
        drives: The motors of the robot, in the order of the chain.
        joints: Joint names of the log.
        warnings: Receives a sentence where the names differ.

    Returns:
        Motor by joint of the log.

    Raises:
        InputError: The robot has another number of motors than the log.
    """
    if len(drives) != len(joints):
        raise InputError(
            f"the robot has {_number_of(drives, 'motor')} and the log has {_number_of(joints, 'joint')} "
            f"({', '.join(joints)}): "
            "they must be the same; give the robot that made the log"
        )
    named = {drive.joint: drive for drive in drives}
    if set(named) == set(joints):
        return {joint: named[joint] for joint in joints}
    warnings.append(
        f"the log names its joints {', '.join(joints)} and the robot {', '.join(named)}, so torque limits were "
        "assigned in the order of the log"
    )
    return dict(zip(joints, drives, strict=True))


def _number_of(things: Sequence[object], name: str) -> str:
    return f"{len(things)} {name}{'' if len(things) == 1 else 's'}"


def motor_tracking(log: Log, start: int, drives: Mapping[str, Drive] | None = None) -> tuple[MotorTracking, ...]:
    """Evaluate tracking and torques of every motor of a log.

    A reference of another rate is interpolated linearly to the stamps of the measurement and of the command.

    Args:
        log: The log.
        start: Stamp that counts as time 0 [ns].
        drives: The motor of each joint; None where not known.

    Returns:
        One result per joint of joint_states, in its order.
    """
    known = {} if drives is None else drives
    clock = _Clock(start)
    return tuple(_motor(log, joint, clock, known.get(joint)) for joint in log.joint_states.names)


@dataclass
class _Clock:
    """Time since the start of a log; series with the same array of stamps share that of their times."""

    start: int
    _known: list[tuple[IntArray, FloatArray]] = field(default_factory=list)

    def seconds(self, stamp: IntArray) -> FloatArray:
        """Return times from the start of the log [s]."""
        for known, time in self._known:
            if known is stamp:
                return time
        time = elapsed_seconds(stamp, self.start)
        self._known.append((stamp, time))
        return time


def _motor(log: Log, joint: str, clock: _Clock, drive: Drive | None) -> MotorTracking:
    position = _signal(log.joint_states, joint, "position")
    goal = _signal(log.joint_reference, joint, "position")
    command = _signal(log.joint_commands, joint, "effort")
    ahead = _signal(log.joint_reference, joint, "effort")
    time, error = None, None
    if position is not None and goal is not None:
        stamp, measured, wanted = _paired(position, goal)
        if len(stamp):
            time, error = clock.seconds(stamp), wanted - measured
    torque_time, torque, feedforward, feedback = None, None, None, None
    if command is not None:
        stamp, torque = command
        if ahead is not None:
            stamp, torque, feedforward = _paired(command, ahead)
            feedback = torque - feedforward
        torque_time = clock.seconds(stamp)
    known = torque is not None and len(torque) > 0
    limit = None if drive is None else drive.torque_limit
    return MotorTracking(
        joint=joint,
        linear=drive is not None and drive.linear,
        time=time,
        error=error,
        tracking=None if error is None or time is None else error_statistics(error, time),
        torque_time=torque_time,
        torque=torque,
        feedforward=feedforward,
        feedback=feedback,
        torque_max=float(np.max(np.abs(torque))) if torque is not None and known else None,
        feedback_rms=None if feedback is None or not known else _rms(feedback),
        feedback_share=None if feedback is None or torque is None or not known else _share(feedback, torque),
        torque_limit=limit,
        limited_by=None if drive is None or not np.isfinite(drive.torque_limit) else drive.limited_by,
        saturated_share=_beyond(torque, limit, -_AT_LIMIT) if known else None,
        overload_share=_beyond(feedforward, limit, _AT_LIMIT) if known else None,
        deflection=_deflection(log, joint, position),
    )


def _deflection(log: Log, joint: str, position: tuple[IntArray, FloatArray] | None) -> float | None:
    """Return the largest deflection of a link about its mean; the zeros of the two encoders may differ."""
    series = log.series("link_states")
    link = _signal(series, joint, "position") if isinstance(series, JointSeries) else None
    if position is None or link is None:
        return None
    _, own, motor = _paired(link, position)
    return float(np.max(np.abs(own - motor - np.mean(own - motor)))) if len(own) else None


def _beyond(torque: FloatArray | None, limit: float | None, margin: float) -> float | None:
    """Share of the samples from limit * (1 + margin) on."""
    return None if torque is None or limit is None else float(np.mean(np.abs(torque) >= limit * (1.0 + margin)))


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _share(feedback: FloatArray, torque: FloatArray) -> float | None:
    total = _rms(torque)
    return _rms(feedback) / total if total > 0.0 else None


def _signal(series: JointSeries | None, joint: str, kind: str) -> tuple[IntArray, FloatArray] | None:
    """Return the finite samples of one joint, in order of stamps; None where the log has none."""
    if series is None or joint not in series.names:
        return None
    table: FloatArray | None = getattr(series, kind)
    if table is None:
        return None
    values = table[:, series.names.index(joint)]
    finite = np.isfinite(values)
    if not np.any(finite):
        return None
    # The arrays of the log where they are whole, not copies.
    return (series.stamp, values) if np.all(finite) else (series.stamp[finite], values[finite])


def _paired(
    main: tuple[IntArray, FloatArray], other: tuple[IntArray, FloatArray]
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the stamps of `main` that `other` covers, and both signals there."""
    stamp, values = main
    known, given = other
    if np.array_equal(stamp, known):
        return stamp, values, given
    inside = (stamp >= known[0]) & (stamp <= known[-1])
    origin = int(known[0])
    at = np.interp((stamp[inside] - origin).astype(np.float64), (known - origin).astype(np.float64), given)
    return stamp[inside], values[inside], at
