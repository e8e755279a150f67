"""Check for commanded positions that the motors do not follow."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.checks.checked_record import CheckedRecord

CLEAR = 0.7
"""Correlation of command and position above which a sign or a factor between them is significant (chosen)."""

SLOW = 1.0
"""Frequency below which a servo follows its command, however soft it is [Hz] (chosen): with gains for walking,
legs follow little of a chirp above a few hertz."""

ENOUGH = 0.1
"""Slow part of a command over the whole, from which it alone tells how far a motor follows [1] (chosen)."""

NOTED = 1.6
"""Factor between the way of a motor and that of its command, either way, above which a warning is given (chosen)."""

REFUSED = 4.0
"""Factor above which the log is rejected: the units of one quantity differ by 6.28 or more, and gears by 4 or more as a
rule, while dry friction and weight hold a weak servo back by up to about 3 (chosen)."""


class ServoFollowing(AbstractCheck):
    """A motor under a servo moves with its command: opposite, scaled or exchanged motion is an error of the log."""

    name: ClassVar[str] = "servo_following"
    stage: ClassVar[int] = 1

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Compare the motions of motors and commands."""
        command, names = checked.record.command, checked.robot.joint_names
        if command is None:
            return ()
        valid = checked.record.valid
        slow, position = (_slow(part, checked.record.sample_time) for part in (command, checked.position))
        tells = slow[valid].std(axis=0) > ENOUGH * command[valid].std(axis=0)
        ways = (np.where(tells, *pair)[valid] for pair in ((position, checked.position), (slow, command)))
        correlation, factor = _compared(*(part - part.mean(axis=0) for part in ways))
        moving = [motor for motor in np.flatnonzero(checked.moves).tolist() if np.ptp(command[:, motor]) > 0]
        swapped = _swapped(correlation, moving)
        if swapped:
            pairs = ", ".join(f"{names[motor]} follows the command of {names[other]}" for motor, other in swapped)
            text = f"the commands belong to other motors ({pairs}); correct the joints when importing"
            return (Finding(text, hopeless=True),)
        problems = []
        for motor in moving:
            own, size = correlation[motor, motor], abs(factor[motor])
            if own < -CLEAR:
                text = f"{names[motor]} moves against its commanded position; correct a sign (sign: -1) when importing"
                problems.append(Finding(text, hopeless=True))
            elif own > CLEAR and abs(np.log(size)) > np.log(REFUSED) and (tells[motor] or size > 1):
                text = (
                    f"{names[motor]} moves {size:.3g} times as far as its command, about 1 is expected of a servo: "
                    "position or command has another unit or is on the other side of the gear; correct it on import"
                )
                problems.append(Finding(text, hopeless=True))
            elif own > CLEAR and size < 1.0 / NOTED:
                text = (
                    f"{names[motor]} moves {size:.3g} times as far as its command, as a weak servo does against dry "
                    "friction, weight or inertia; where its gear ratio is in doubt, check gear_ratio of the mapping"
                )
                problems.append(Finding(text, hopeless=False))
            elif own > CLEAR and size > NOTED:
                text = (
                    f"{names[motor]} moves {size:.3g} times as far as its command, as a servo near its resonance does; "
                    "where its gear ratio is in doubt, check gear_ratio of the mapping"
                )
                problems.append(Finding(text, hopeless=False))
        return tuple(problems)


def _slow(signal: FloatArray, sample_time: float) -> FloatArray:
    """Return what of signals is below `SLOW`, shape (n, M), or all of them where they are too short or slow to tell."""
    from scipy.signal import butter, sosfiltfilt  # here, because it loads slowly

    if len(signal) * sample_time * SLOW < 1 or sample_time * SLOW > 0.2:
        return signal
    return np.asarray(sosfiltfilt(butter(2, SLOW, fs=1 / sample_time, output="sos"), signal, axis=0))


def _compared(position: FloatArray, command: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the correlation of every motion with every command, shape (M, M), and motion over command, shape (M,)."""
    sizes = np.maximum(np.linalg.norm(position, axis=0), 1e-300), np.maximum(np.linalg.norm(command, axis=0), 1e-300)
    products = position.T @ command
    return products / np.outer(*sizes), np.maximum(np.abs(np.diag(products)), 1e-300) / sizes[1] ** 2


def _swapped(correlation: FloatArray, moving: list[int]) -> list[tuple[int, int]]:
    """List motors that clearly follow the command of another one, with that one."""
    if len(moving) < 2:
        return []
    from scipy.optimize import linear_sum_assignment  # here, because it loads slowly

    among = correlation[np.ix_(moving, moving)]
    rows, columns = linear_sum_assignment(-among)
    found = [(moving[row], moving[column]) for row, column in zip(rows, columns) if row != column]
    if not found or not all(correlation[motor, other] > CLEAR > correlation[motor, motor] for motor, other in found):
        return []
    return found
