"""Check for a position that is clipped or wraps around."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.checks.repeated_values import comes_to_rest, slow_change
from flexros.record.missing_samples import MOST_BRIDGED, runs
from flexros.record.quantization import encoder_step

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.record.checks.checked_record import CheckedRecord

PLATEAU = 8
"""Fewest equal samples in a row at the extreme of a position that form a flat top (chosen)."""

CONTINUOUS = 0.5
"""Share of different values above which an encoder has noise in every sample; a coarse one rests at its extremes
(chosen)."""

JUMP = 0.4
"""Step between two samples over the range of an encoder above which it wrapped around (chosen)."""

OTHERS = 0.25
"""All steps that are no such ones over the largest [1] (chosen)."""

FAR = 20.0
"""Such a step over the median one of those that are not zero (chosen): an encoder that stands still steps by its
resolution, which is all the range it has."""

SMALLEST = 1e-3
"""Smallest range of an encoder [rad or m] (chosen): positions within less are of a motor at rest, whose noise jumps."""

MOST = 0.05
"""Share of samples in flat tops above which a log is rejected (chosen)."""


class ClippedEncoder(AbstractCheck):
    """A position at the end of the encoder's range, or one that wraps around, does not follow the motor."""

    name: ClassVar[str] = "clipped_encoder"
    stage: ClassVar[int] = 1

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Find flat tops and jumps over the whole range."""
        record, robot = checked.record, checked.robot
        problems = []
        rows = np.flatnonzero(record.valid)
        near = np.diff(rows) <= MOST_BRIDGED  # behind a hole the motor may be anywhere
        for motor, name in enumerate(robot.joint_names):
            values = record.position[rows, motor]
            span, step = float(np.ptp(values)), encoder_step(record, motor)
            steps = np.abs(np.diff(values))[near]
            if span > SMALLEST and _wraps(steps, span, step):
                at = float(rows[:-1][near][int(np.argmax(steps))]) * record.sample_time
                text = (
                    f"the position of {name} jumps by {steps.max():.4g} at {at:.4g} s, as an encoder that wraps around "
                    "or is reset; give its range as 'period' in the mapping, or cut the log there"
                )
                problems.append(Finding(text, hopeless=True))
                continue
            if len(np.unique(values)) < CONTINUOUS * len(values) or not checked.moves[motor]:
                continue
            spoilt = _flat_tops(values, step, record.valid)
            flat = int(spoilt.sum())
            if flat:
                text = (
                    f"the position of {name} stays at the end of its range in {flat} samples although it varies in "
                    "every sample elsewhere: the encoder or the recorder clips it; these samples do not count"
                )
                problems.append(Finding(text, flat > MOST * len(values), spoilt))
        return tuple(problems)


def _wraps(steps: FloatArray, span: float, step: float) -> bool:
    """Whether the largest step is one of the whole range among small ones."""
    largest, usual = float(steps.max(initial=0.0)), float(np.median(steps[steps > 0]))
    others = float(steps[steps <= JUMP * span].max(initial=0.0))
    small = float(np.median(steps)) < 1e-3 * span or others < OTHERS * largest
    return largest > JUMP * span and largest > FAR * max(usual, step) and small


def _flat_tops(values: FloatArray, step: float, valid: BoolArray) -> BoolArray:
    """Mark the samples in which the position is cut off at its largest or smallest value.

    At a turning point and at rest an encoder without noise repeats its value too, but comes or leaves slowly. A log
    that begins or ends at the extreme, or is interrupted there, tells too little.
    """
    rows, spoilt = np.flatnonzero(valid), np.zeros(len(valid), dtype=bool)
    slow = slow_change(values, step)
    for level in (values.max(), values.min()):
        for begin, length in zip(*runs(values == level), strict=True):
            around = rows[max(begin - 1, 0) : begin + length + 1]
            inside = len(around) == length + 2 and int(np.diff(around).max()) <= MOST_BRIDGED
            rests = comes_to_rest(values, int(begin), int(length), slow, at_end=True)
            if inside and length >= PLATEAU and not rests:
                spoilt[rows[begin : begin + length]] = True
    return spoilt
