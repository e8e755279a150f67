"""Whether positions are degrees that were taken as radians."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.balance.joint_assignments import clearly_better, own_score, score
from flexros.record.balance.spectra import torque_balance

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

MOST = 4 * np.pi
"""Largest angle of a joint whose unit is not doubted [rad] (chosen): two turns, as in the import of a bag. Ranges of
robot joints end at one or two; in degrees a motion of a quarter of a radian is beyond."""


def like_degrees(checked: CheckedRecord) -> str:
    """Return what is wrong where angles beyond two turns fit the torques far better in degrees; empty where not.

    Args:
        checked: The record under check.
    """
    record, robot = checked.record, checked.robot
    rotary = np.array([motor.rotary for motor in robot.motors])
    reached = np.where(rotary, np.abs(record.position[record.valid]).max(axis=0, initial=0.0), 0.0)
    far = reached > MOST
    if not np.any(far) or checked.balance is None:
        return ""
    angles = np.where(rotary, np.radians(record.position), record.position)
    in_degrees = own_score(torque_balance(replace(record, position=angles), robot), robot.n_motors)
    if in_degrees is None or not clearly_better(in_degrees, score(checked.own)):
        return ""
    named = ", ".join(f"{robot.joint_names[k]}: {reached[k]:.4g} rad" for k in np.flatnonzero(far))
    turns = reached.max() / (2 * np.pi)
    return (
        f"positions reach {turns:.3g} turns ({named}), and torques fit robot {robot.name} far better where they "
        f"are degrees (agreement {in_degrees:.2f} of 1): give 'unit: deg', and deg/s for speeds, when importing"
    )
