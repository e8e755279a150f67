"""The gap between robot and model before and after a repair, as it is stated."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.gap.held_out.closed_share import closed_fraction
from flexros.gap.result import SignalGap
from flexros.gap.schema import GapNumbers

if TYPE_CHECKING:
    from collections.abc import Iterable

    from flexros.effects.kinds.base import AbstractEffect
    from flexros.gap.held_out.errors_ahead import AheadErrors
    from flexros.record.record import Record
    from flexros.robot import Robot

METRIC = "mean squared prediction error 0.1 s ahead over its floor variance"
SETTLES = 0.5
"""Closed share of the gap from which a repaired model explains the log, so that it is of this robot [1] (chosen)."""
WHOLE = 1.0
"""The share that is closed of no gap: the nominal model explains the log [1]."""

_MILLI, _MICRO = 1e-3, 1e-6
_SMALL = 1e-4
"""Errors below this are stated in millionths, others in thousandths [rad or m] (chosen)."""


def settled(record: Record, closed: float | None, explained_by: Iterable[AbstractEffect] | None) -> Record:
    """Return a record without the warnings that doubt the model, where a repair closes much of its gap or it has none.

    Doubts about the model or the torques are settled where the log is explained and no error of the torque gain, as
    which a wrong unit or torque constant would be found, takes part.

    Args:
        record: The log.
        closed: Share of the gap that the repaired model closes [1]; None without one; `WHOLE` where there is no gap.
        explained_by: Effects of a repair that explains the log; None for none.
    """
    doubts = () if closed is None or closed < SETTLES else record.doubts
    if explained_by is not None and all(one.gain == 1 for one in explained_by if isinstance(one, AbstractCommandLaw)):
        doubts += record.open_doubts
    return record.without_warnings(doubts)


def gap_numbers(
    before: AheadErrors,
    after: AheadErrors | None,
    sample_time: float,
    rival: AheadErrors | None = None,
    with_tolerance: float | None = None,
) -> GapNumbers:
    """State the gap before and after a repair.

    Args:
        before: Errors of the nominal model.
        after: Errors of the repaired model, at the same windows; None where nothing was repaired.
        sample_time: Time between two samples [s].
        rival: Errors of the best explanation that was not chosen, None for none.
        with_tolerance: The gap of torques that are off by their tolerance [1]; None where they are exact.
    """
    share = None if after is None else closed_fraction(before, after, sample_time)
    return GapNumbers(
        metric=METRIC,
        unit="1",
        before=before.mean,
        after=None if after is None else after.mean,
        noise_floor=1.0,
        tolerance_floor=with_tolerance,
        best_rival=None if rival is None else rival.mean,
        closed_fraction=None if share is None else share.value,
        interval=None if share is None else share.interval,
    )


def signal_gaps(
    robot: Robot, before: AheadErrors, after: AheadErrors | None = None, rival: AheadErrors | None = None
) -> tuple[SignalGap, ...]:
    """Return the root mean square of the prediction errors of each motor position and further sensor.

    Args:
        robot: The robot.
        before: Errors of the nominal model.
        after: Errors of the repaired model, None for none.
        rival: Errors of the best explanation that was not chosen, None for none.
    """
    motors = [motor for index, motor in enumerate(robot.motors) if index not in before.prescribed]
    signals = [(f"{motor.name} position", motor.position_unit) for motor in motors]
    signals += [(sensor.name, sensor.unit) for sensor in before.sensors]
    gaps = []
    for column, (name, unit) in enumerate(signals):
        scale, prefix = (_MICRO, "µ") if before.rms(column) < _SMALL else (_MILLI, "m")
        if column >= len(motors) and before.rms(column) >= 1.0:
            scale, prefix = 1.0, ""
        gaps.append(
            SignalGap(
                signal=f"{name}, 0.1 s ahead",
                unit=f"{prefix}{unit}",
                before=before.rms(column) / scale,
                after=None if after is None else after.rms(column) / scale,
                floor=float(before.floor[column]) / scale,
                rival=None if rival is None else rival.rms(column) / scale,
            )
        )
    return tuple(gaps)
