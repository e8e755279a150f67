"""Check for a torque that is clipped or beyond its limit."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.feedforward.rigid_arm import rigid_arm
from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.missing_samples import runs

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.checks.checked_record import CheckedRecord

PLATEAU = 3
"""Fewest samples in a row at the extreme of a torque that form a flat top (chosen)."""

LEAST_SHARE = 5e-4
"""Share of samples in flat tops above which a torque is clipped (chosen)."""

SUDDEN = 0.2
"""Steps to and from a flat top over the range of the torque, from which it is a step of the command (chosen)."""

ROUNDED = 1.5
"""Steps of the record to and from a flat top up to which it is the rounding of a smooth one [1] (chosen)."""

CONTINUOUS = 0.3
"""Share of different values above which a torque is continuous; steps and binary signals have flat tops of their own
(chosen)."""

AT_LIMIT = 0.01
"""Relative distance to the limit of the robot file within which a level is that limit (chosen)."""

BEYOND_LIMIT = 1.05
"""Torque over the limit of the robot file above which it is reported (chosen)."""


FREE = 0.3
"""Torque that the bodies need for a motion over that of their weight, rms, below which the arm swings freely [1]
(chosen): friction is a small part of it, or the swing would end at once."""

EVERY = 10
"""Samples of which one is looked at there (chosen)."""

NOTHING = "all torques are zero, so nothing drives the motion; record the commands or the measured torques"


class ClippedTorque(AbstractCheck):
    """A torque that is clipped only in the log, or only at the motor, is not the one that acted."""

    name: ClassVar[str] = "clipped_torque"
    stage: ClassVar[int] = 1
    of_torque: ClassVar[bool] = True

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Find zero torques, flat tops, and torques beyond the limit."""
        record, robot = checked.record, checked.robot
        if not np.any(record.torque):
            return () if _swings(checked) else (Finding(NOTHING, hopeless=True),)
        problems = []
        for motor, name in enumerate(robot.joint_names):
            values, limit = record.torque[record.valid, motor], float(robot.torque_limits[motor])
            problems += _beyond(values, limit, name)
            levels = _flat_tops(values)
            if levels:
                problems.append(_clipped(name, levels, limit))
        return tuple(problems)


def _swings(checked: CheckedRecord) -> bool:
    """Return whether the weight of the arm drives its motion, as in a swing with its drives off."""
    motion, arm = checked.motion[:, ::EVERY], rigid_arm(checked.robot)
    needed = arm.inverse_dynamics(motion).torque
    weight = arm.inverse_dynamics(motion * np.array([1.0, 0.0, 0.0])[:, None, None]).torque
    return bool(np.sum(needed**2) < FREE**2 * np.sum(weight**2))


def _flat_tops(values: FloatArray) -> list[float]:
    """Return the extremes at which a continuous signal has flat tops."""
    if len(np.unique(values)) < CONTINUOUS * len(values):
        return []
    levels, step = [], ROUNDED * float(np.diff(np.unique(values)).min())
    for level in (float(values.max()), float(values.min())):
        begin, length = runs(np.abs(values - level) <= 1e-9 * abs(level))
        before = np.abs(values[np.maximum(begin - 1, 0)] - level)
        after = np.abs(values[np.minimum(begin + length, len(values) - 1)] - level)
        cut = (np.minimum(before, after) < SUDDEN * np.ptp(values)) & (np.maximum(before, after) > step)
        flat = int(length[(length >= PLATEAU) & cut].sum())
        if flat > LEAST_SHARE * len(values) and level != 0.0:
            levels.append(level)
    return levels


def _clipped(name: str, levels: list[float], limit: float) -> Finding:
    text = " and ".join(f"{level:.6g}" for level in levels)
    if all(abs(abs(level) / limit - 1) < AT_LIMIT for level in levels):
        return Finding(
            f"the torque of {name} is at its limit {text} in parts; torque beyond the limit is not in the log",
            hopeless=False,
        )
    allowed = f"the robot file allows {limit:.6g}" if np.isfinite(limit) else "the robot file has no limit"
    return Finding(
        f"the torque of {name} is clipped at {text}, but {allowed}: the recorder or the drive clips it; record the "
        "torque that acts, or correct torque_limit",
        hopeless=False,
    )


def _beyond(values: FloatArray, limit: float, name: str) -> list[Finding]:
    largest = float(np.abs(values).max(initial=0.0))
    if largest <= BEYOND_LIMIT * limit:
        return []
    return [
        Finding(
            f"the torque of {name} reaches {largest:.6g}, but the robot file allows {limit:.6g}; the drive cuts it "
            "off, or its unit or side of the gear is another one",
            hopeless=False,
        )
    ]
