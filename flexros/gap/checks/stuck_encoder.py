"""Whether an encoder repeats its value while all else shows that it should not."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.checks.base import AbstractCheck, Finding
from flexros.gap.repeats import longest_repeat

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.checked_record import CheckedRecord

USUAL_REPEATS = 0.02
"""Share of samples equal to the one before, up to which an encoder has noise in every sample (chosen)."""

LONGEST = 8
"""Equal samples in a row that an encoder with noise never has (chosen)."""

DRIVEN = 0.3
"""Rms torque of a constant encoder over that of its torque in the whole log from which it is driven (chosen)."""

MOST = 0.3
"""Share of stuck samples from which a log is refused (chosen)."""


class StuckEncoder(AbstractCheck):
    """An encoder with noise in every sample cannot repeat its value; a coarse one may, at standstill."""

    name: ClassVar[str] = "stuck_encoder"
    stage: ClassVar[int] = 1

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Look for equal samples in a row."""
        record, robot = checked.record, checked.robot
        rows = [np.flatnonzero(record.valid)]
        found = []
        for motor, name in enumerate(robot.joint_names):
            values, torque = record.position[rows[0], motor], record.torque[rows[0], motor]
            if np.ptp(values) == 0.0:
                found += _constant(name, torque)
                continue
            same = np.diff(values) == 0.0
            length, begin = longest_repeat(same)
            if length < LONGEST:
                continue
            outside = np.delete(same, slice(begin, begin + length))
            if outside.size and outside.mean() > USUAL_REPEATS:
                continue
            share = length / len(values)
            found.append(
                Finding(
                    f"the encoder of {name} repeats one value for {(length + 1) * record.sample_time:.3g} s from "
                    f"{rows[0][begin] * record.sample_time:.4g} s on although its samples differ elsewhere, so it was "
                    "stuck or its messages were repeated; cut the log there or repair the recorder",
                    hopeless=share > MOST,
                )
            )
        return tuple(found)


def _constant(name: str, torque: FloatArray) -> list[Finding]:
    """Judge an encoder that never changes: stuck where the torque varies as much as it is large."""
    driven = float(np.std(torque)) > DRIVEN * float(np.sqrt(np.mean(torque**2))) > 0
    if not driven:
        return [Finding(f"the position of {name} never changes; nothing can be told of it", hopeless=False)]
    text = (
        f"the position of {name} never changes although its torque does: its encoder is stuck, or its brake is closed; "
        "check the encoder, or release the brake"
    )
    return [Finding(text, hopeless=True)]
