"""Check for a stuck encoder."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.checks.repeated_values import comes_to_rest, slow_change
from flexros.record.missing_samples import MOST_BRIDGED, runs
from flexros.record.quantization import encoder_step

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.record.checks.checked_record import CheckedRecord
    from flexros.record.record import Record

USUAL_REPEATS = 0.02
"""Share of samples equal to the one before up to which an encoder has noise in every sample (chosen)."""

LONGEST = 8
"""Fewest equal samples in a row that count as stuck for an encoder with noise (chosen)."""

DRIVEN = 0.3
"""Standard deviation over rms of the torque above which a motor with a constant position is driven (chosen)."""

STILL = 0.01
"""Range of a reference, or largest measured speed, over that of the motor that moves most, below which a motor stands
still (chosen)."""

MOST = 0.3
"""Share of stuck samples above which a log is rejected (chosen)."""


class StuckEncoder(AbstractCheck):
    """An encoder with noise in every sample cannot repeat its value; a coarse one can, at rest."""

    name: ClassVar[str] = "stuck_encoder"
    stage: ClassVar[int] = 1

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Find equal samples in a row."""
        record, robot = checked.record, checked.robot
        rows = np.flatnonzero(record.valid)
        constant = np.flatnonzero(np.ptp(record.position[rows], axis=0) == 0.0).tolist()
        problems = _constant(checked, [motor for motor in constant if motor not in record.prescribed])
        for motor, name in enumerate(robot.joint_names):
            if motor in constant:
                continue
            values = record.position[rows, motor]
            stuck = _stuck(values, rows, encoder_step(record, motor))
            if not checked.moves[motor] or not np.any(stuck):
                continue
            spoilt = np.zeros(record.n_samples, dtype=bool)
            spoilt[rows[stuck]] = True
            text = (
                f"the encoder of {name} repeats its value in {int(stuck.sum())} samples, the first at "
                f"{float(rows[np.argmax(stuck)]) * record.sample_time:.4g} s, although its samples differ elsewhere: "
                "it was stuck, or the recorder repeated messages; these samples do not count"
            )
            problems.append(Finding(text, float(stuck.mean()) > MOST, spoilt))
        return tuple(problems)


def _stuck(values: FloatArray, rows: IntArray, step: float) -> BoolArray:
    """Mark the samples that repeat the one before in long stretches.

    An encoder that often repeats its value elsewhere, or that comes to rest slowly, is not stuck. A value after a long
    hole repeats none.
    """
    slow = slow_change(values, step)
    same = np.concatenate([[False], (np.diff(values) == 0.0) & (np.diff(rows) <= MOST_BRIDGED)])
    stuck = np.zeros(len(values), dtype=bool)
    ends = values == values.max(), values == values.min()  # flat tops belong to another check
    for begin, length in zip(*runs(same), strict=True):
        rests = comes_to_rest(values, int(begin), int(length), slow)
        if length >= LONGEST and not rests and not any(end[begin] for end in ends):
            stuck[begin : begin + length] = True
    outside = same[~stuck & ~ends[0] & ~ends[1]]
    if outside.size and outside.mean() > USUAL_REPEATS:
        stuck[:] = False
    return stuck


def _stands_still(record: Record, motor: int) -> bool:
    """Whether reference or measured speed say that a motor stands still while others move."""
    for values, size in ((record.reference, np.ptp), (record.velocity, lambda v, axis: np.abs(v).max(axis=axis))):
        if values is not None and np.isfinite(values[:, motor]).all():
            sizes = size(values, axis=0)
            return bool(sizes[motor] < STILL * np.nanmax(sizes))
    return False


def _constant(checked: CheckedRecord, motors: Sequence[int]) -> list[Finding]:
    """Judge positions that never change: stuck where the torque varies as much as it is large.

    Of several such joints of a real machine at once none is stuck: something holds them.
    """
    record, names = checked.record, checked.robot.joint_names
    torque = record.torque[record.valid]
    varies = np.std(torque, axis=0) > DRIVEN * np.sqrt(np.mean(torque**2, axis=0))
    several = record.imported and len(motors) > 1
    stuck = [] if several else [motor for motor in motors if varies[motor] and not _stands_still(record, motor)]
    problems = [
        Finding(
            f"the position of {names[motor]} never changes although its torque does: its encoder is stuck, or its "
            "brake is closed; check the encoder, release the brake, or name it as prescribed where it was held",
            hopeless=True,
        )
        for motor in stuck
    ]
    still = [names[motor] for motor in motors if motor not in stuck]
    if len(still) > 1:
        text = f"the positions of {', '.join(still)} never change; nothing about these motors is identifiable"
        problems.append(Finding(text, hopeless=False))
    elif still:
        text = f"the position of {still[0]} never changes; nothing about it is identifiable"
        problems.append(Finding(text, hopeless=False))
    return problems
