"""Whether the torque was recorded in coarse steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.quantization import lattice_step

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

COARSE = 0.005
"""Step over the rms of a torque from which it is told (chosen)."""

FEWEST_LEVELS = 8
"""Fewest different values: below, the torque is a step or a binary signal (chosen)."""


class CoarseTorque(AbstractCheck):
    """Rounding of the recorded torque is noise that the motor never felt."""

    name: ClassVar[str] = "coarse_torque"
    stage: ClassVar[int] = 1

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Look for a lattice in the torques."""
        record = checked.record
        found = []
        for motor, name in enumerate(checked.robot.joint_names):
            values = record.torque[record.valid, motor]
            step = lattice_step(values) if len(np.unique(values)) >= FEWEST_LEVELS else None
            rms = float(np.sqrt(np.mean(values**2)))
            if step is not None and step > COARSE * rms:
                found.append(
                    Finding(
                        f"the torque of {name} was recorded in steps of {step:.3g}, {100 * step / rms:.2g} % of its "
                        "rms; weak effects hide below; record it finer",
                        hopeless=False,
                    )
                )
        return tuple(found)
