"""Check for jumps of the clock of a recording: all joints go on by more or less of their motion than stamps say."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.quantization import encoder_step

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.record.checks.checked_record import CheckedRecord
    from flexros.record.record import Record

NEIGHBOURS = np.array([-1.0, 4.0, 0.0, 4.0, -1.0]) / 6.0
"""Weights of the steps beside one that a cubic through them has there."""
BESIDE = np.array([-3, -2, -1, 1, 2, 3])
"""The neighbours of a step through which a parabola is laid."""
CLEAR = 8.0
"""Jump over its standard deviation from which there is one [1] (chosen): far beyond noise."""
LEAST = 0.03
"""Least jump [samples] (chosen): less is jitter of a clock."""
ALIKE = 0.8
"""Share of what is unusual in a step of all joints that one jump explains, from which it is one of the clock [1]
(chosen): an impact changes speeds, and an encoder that errs does so alone."""
FEWEST = 2
"""Fewest joints that move enough to show a jump by themselves (chosen): one alone may have hit something."""
SHOWS = 3.0
"""Jump over its standard deviation by one joint, from which it shows it, and at twice of which it must [1] (chosen)."""
MOVES = 0.5
"""Least step before and after one, over that which its neighbours expect of it, with the same sign, where a joint moves
there [1] (chosen): motion that begins or ends goes on by nothing in a step, as under a clock that stands does.
"""
OUTSIDE = 2.5
"""Least deviation of a step from a parabola through its six neighbours, over what that leaves of these, where the clock
jumps [1] (chosen): 2.2 and less where torques change speeds at once, in logs of a simulator that is not ours; 3.2 and
more where a clock jumps, and 20 where it does so once."""
RARE = 0.002
"""Largest share of samples with jumps (chosen): more is the jitter of a clock, which counts as noise."""


class ClockJump(AbstractCheck):
    """Between two samples all joints go on by 1 + d steps of their motion around it, for the same d.

    A clock that is set, a cycle that is lost or done twice, and two samples under one stamp look like this. No effect
    of a robot does: a force changes speeds, not positions at once. One sample between two such steps is displaced.
    """

    name: ClassVar[str] = "clock_jump"
    stage: ClassVar[int] = 1

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Warn of the instants; what is predicted across them does not count."""
        record = checked.record
        if not record.imported:
            return ()
        rows = np.flatnonzero(record.valid)
        jumps, sizes = _jumps(record, rows)
        if not 0 < len(jumps) <= max(RARE * len(rows), 2):
            return ()
        marked: FloatArray = np.zeros(record.n_samples)
        marked[rows[jumps + 1]] = sizes
        largest = int(np.argmax(np.abs(sizes)))
        at = record.begin + float(rows[jumps[largest] + 1]) * record.sample_time
        text = (
            f"the clock of the recording jumps at {len(jumps)} instant{'s' if len(jumps) > 1 else ''} (most at "
            f"{at:.4g} s, where all joints go on by {1 + sizes[largest]:.3g} samples of their motion in one): what is "
            "predicted across does not count where that shows"
        )
        return (Finding(text, hopeless=False, jumps=marked),)


def _jumps(record: Record, rows: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the steps between measured samples that jump, and by how many samples.

    Args:
        record: The log.
        rows: Its measured samples.
    """
    nothing = np.zeros(0, dtype=np.int64), np.zeros(0)
    if len(rows) < 100:
        return nothing
    between = np.diff(rows)
    steps = np.diff(record.position[rows], axis=0) / between[:, None]
    kernel = NEIGHBOURS[:, None]
    usual = sum(weight * np.roll(steps, 2 - place, axis=0) for place, weight in enumerate(kernel))
    unusual = steps - usual
    beside = np.stack([np.roll(steps, 1, axis=0), np.roll(steps, -1, axis=0)]) * np.sign(usual)
    unusual[:2], unusual[-2:] = 0.0, 0.0
    speeds = np.abs(usual)
    resolution = np.array([encoder_step(record, motor) for motor in range(steps.shape[1])])
    spread = np.empty(steps.shape[1])
    for motor, speed in enumerate(speeds.T):
        fast = speed >= np.median(speed)
        spread[motor] = max(1.4826 * np.median(np.abs(unusual[fast, motor])), resolution[motor] / 2, 1e-12)
    moving = beside.min(axis=0) >= MOVES * speeds
    share, weighed = np.where(moving, usual, 0.0) / spread, unusual / spread
    information = np.sum(share**2, axis=1)
    size = np.sum(share * weighed, axis=1) / np.maximum(information, 1e-300)
    whole = np.sum(weighed**2, axis=1)
    left = np.sum((weighed - size[:, None] * share) ** 2, axis=1)
    expected = size[:, None] * share
    agrees = np.abs(weighed - expected) < np.abs(expected) / 2
    shows = agrees & (np.abs(expected) > SHOWS)
    shown = np.sum(shows, axis=1) >= FEWEST
    shown &= ~np.any(~agrees & (np.abs(expected) > 2 * SHOWS), axis=1)
    clear = (
        (np.abs(size) * np.sqrt(information) > CLEAR) & (np.abs(size) > LEAST) & (left <= (1 - ALIKE) * whole) & shown
    )
    strength = np.abs(size) * np.sqrt(information) * clear
    around = np.stack([np.roll(strength, shift) for shift in (-2, -1, 1, 2)])
    found = np.flatnonzero(clear & (strength >= around.max(axis=0)))
    found = found[[_stands_out(steps[:, shows[step]] / spread[shows[step]], step) for step in found.tolist()]]
    return (found, size[found]) if len(found) else nothing


def _stands_out(steps: FloatArray, at: int) -> bool:
    """Return whether a step deviates from a smooth motion through its neighbours, which do not.

    Where a torque changes the speeds of all joints at once, the steps around it are no smooth motion either.

    Args:
        steps: Steps of the joints that show a jump, over their usual deviation, shape (n, joints).
        at: The step.
    """
    beside = at + BESIDE
    if beside[0] < 0 or beside[-1] >= len(steps):
        return True
    parabola = np.vander(BESIDE.astype(float), 3)
    numbers, *_ = np.linalg.lstsq(parabola, steps[beside], rcond=None)
    rest = np.sum((steps[beside] - parabola @ numbers) ** 2) / (len(beside) - 3)
    return bool(np.sum((steps[at] - numbers[-1]) ** 2) > OUTSIDE**2 * rest)
