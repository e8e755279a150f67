"""Check that the motors move, and long enough."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

FEWEST = 200
"""Fewest samples in motion (chosen)."""

SLOWEST = 0.02
"""Speed over the largest one above which a sample is in motion [1] (chosen)."""


class Motion(AbstractCheck):
    """Without motion there is nothing to predict."""

    name: ClassVar[str] = "motion"
    stage: ClassVar[int] = 1

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Compare the motion of every motor with its noise."""
        robot, speed, moves = checked.robot, checked.motion[1], checked.moves
        if not np.any(moves):
            return (
                Finding(
                    "no motor moves beyond the noise of its encoder, so there is no excitation; record a log in which "
                    "the motors move",
                    hopeless=True,
                ),
            )
        in_motion = np.any((np.abs(speed) > SLOWEST * np.abs(speed).max(axis=0))[:, moves], axis=1)
        if in_motion.sum() < FEWEST:
            return (
                Finding(
                    f"the motors move in {int(in_motion.sum())} samples only, at least {FEWEST} are needed; record a "
                    "longer motion",
                    hopeless=True,
                ),
            )
        told = np.ptp(checked.record.position[checked.record.valid], axis=0) == 0.0  # by the check for stuck encoders
        told[list(checked.record.prescribed)] = True
        still = [robot.joint_names[motor] for motor in np.flatnonzero(~moves & ~told)]
        if not still:
            return ()
        text = f"{still[0]} does not move beyond the noise of its encoder, so little about it is identifiable"
        if len(still) > 1:
            text = (
                f"{', '.join(still)} do not move beyond the noise of their encoders, so little about them is "
                "identifiable"
            )
        return (Finding(text, hopeless=False),)
