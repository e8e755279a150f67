"""The gap of each motor in units that a user feels: how far off a prediction 0.1 s ahead is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.result import SignalGap

if TYPE_CHECKING:
    from flexros.gap.held_out.prediction_gap import AheadErrors
    from flexros.robot import Robot

_MILLI, _MICRO = 1e-3, 1e-6
_SMALL = 1e-4
"""Errors below this are told in millionths, others in thousandths [rad or m] (chosen)."""


def signal_gaps(
    robot: Robot, before: AheadErrors, after: AheadErrors | None = None, rival: AheadErrors | None = None
) -> tuple[SignalGap, ...]:
    """Tell the gap of each motor position.

    Args:
        robot: The robot, which tells what turns and what slides.
        before: Errors of the nominal model.
        after: Errors of the repaired model, None for none.
        rival: Errors of the best explanation that was not chosen, None for none.

    Returns:
        Root mean squares, one entry per motor.
    """
    gaps = []
    for motor, name in enumerate(robot.joint_names):
        first = _rms(before, motor)
        scale, prefix = (_MICRO, "µ") if first < _SMALL else (_MILLI, "m")
        gaps.append(
            SignalGap(
                signal=f"{name} position, 0.1 s ahead",
                unit=f"{prefix}{robot.motors[motor].position_unit}",
                before=first / scale,
                after=None if after is None else _rms(after, motor) / scale,
                floor=float(before.floor[motor]) / scale,
                rival=None if rival is None else _rms(rival, motor) / scale,
            )
        )
    return tuple(gaps)


def _rms(errors: AheadErrors, motor: int) -> float:
    """Return the root mean square of the errors of a motor [rad or m]."""
    return float(errors.floor[motor] * np.sqrt(errors.squares[:, motor].mean()))
