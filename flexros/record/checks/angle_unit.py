"""Check for positions in degrees."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.balance.joint_assignments import clearly_better, own_fits, score
from flexros.record.balance.spectra import torque_balance
from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.checks.unit import Unit

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

MOST = 4 * np.pi
"""Largest angle of a joint whose unit is not doubted [rad] (chosen): two turns, as in the import of a bag. Ranges of
robot joints end at one or two; in degrees a motion of a quarter of a radian is beyond."""


class AngleUnit(AbstractCheck):
    """Degrees taken as radians turn the weight of an arm many times round, so that no factor of a unit shows it."""

    name: ClassVar[str] = "angle_unit"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Try angles beyond two turns in degrees."""
        record, robot = checked.record, checked.robot
        rotary = np.array([motor.rotary for motor in robot.motors])
        reached = np.where(rotary, np.abs(record.position[record.valid]).max(axis=0, initial=0.0), 0.0)
        far = reached > MOST
        if not np.any(far) or checked.balance is None or Unit().look(checked):
            return ()
        angles = np.where(rotary, np.radians(record.position), record.position)
        in_degrees = score(own_fits(torque_balance(replace(record, position=angles), robot), robot.n_motors))
        if in_degrees is None or not clearly_better(in_degrees, score(checked.own)):
            return ()
        named = ", ".join(f"{robot.joint_names[k]}: {reached[k]:.4g} rad" for k in np.flatnonzero(far))
        turns = reached.max() / (2 * np.pi)
        text = (
            f"positions reach {turns:.3g} turns ({named}), and torques fit robot {robot.name} far better where they "
            f"are degrees (agreement {in_degrees:.2f} of 1): give 'unit: deg', and deg/s for speeds, when importing"
        )
        return (Finding(text, hopeless=True),)
