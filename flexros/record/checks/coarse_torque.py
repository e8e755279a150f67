"""Check for a coarsely quantised torque."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.quantization import lattice_step

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

COARSE = 0.005
"""Step over the rms of a torque above which it is reported (chosen)."""

FEWEST_LEVELS = 8
"""Fewest different values; a torque with fewer is a step or a binary signal (chosen)."""


class CoarseTorque(AbstractCheck):
    """Rounding of the recorded torque is noise that did not act on the motor."""

    name: ClassVar[str] = "coarse_torque"
    stage: ClassVar[int] = 1
    of_torque: ClassVar[bool] = True

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Find quantisation steps of the torques."""
        record = checked.record
        recorded = record.torque if record.noted is None else record.noted  # means of two samples have half the step
        problems = []
        for motor, name in enumerate(checked.robot.joint_names):
            values = recorded[record.valid, motor]
            step = lattice_step(values) if len(np.unique(values)) >= FEWEST_LEVELS else None
            rms = float(np.sqrt(np.mean(values**2)))
            if step is not None and step > COARSE * rms:
                problems.append(
                    Finding(
                        f"the torque of {name} was recorded in steps of {step:.3g}, {100 * step / rms:.2g} % of its "
                        "rms; weak effects remain undetected; record it more finely",
                        hopeless=False,
                    )
                )
        return tuple(problems)
