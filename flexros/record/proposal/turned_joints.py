"""Joints that a log counts the other way round than the model: with them turned, its torques fit the motion."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.balance.joint_assignments import RIGHT_ANGLES
from flexros.record.proposal.effort_comparison import EffortComparison

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.record.proposal.effort_comparison import Comparison
    from flexros.record.record import Record
    from flexros.robot import Robot

CLEAR = float(np.log(4.0))
"""Fall of the unexplained shares, sum of the logarithms over all motors, from which a joint is turned [1] (chosen): 1.8
and more where a joint that carries weight counts the other way, 0.7 at most in logs of measured robots with right
signs."""
LEAST = 0.01
"""Unexplained share of a torque below which less is no evidence [1] (chosen)."""
MOST_LEFT, MOST_OF_BEFORE = 0.2, 0.8
"""Largest mean of the unexplained shares with which joints are turned, and over the mean as the log is [1] (chosen):
beyond it something else is wrong, such as the order of the joints or the zero of one."""
MOST = 2
"""Most joints that are turned (chosen)."""
ALIKE = 0.05
"""Difference of these falls up to which others explain the log as well [1] (chosen): an arm whose axes are all
parallel moves in a mirror as one with another joint turned."""


@dataclass(frozen=True)
class TurnedJoints:
    """Joints that count the other way, found in a log.

    Attributes:
        motors: Their numbers from 0.
        before: Mean of the shares of the torques that the model and friction leave unexplained as the log is [1].
        after: The same with these joints turned [1].
        alike: Other joints that explain as much in their place.
    """

    motors: tuple[int, ...]
    before: float
    after: float
    alike: tuple[tuple[int, ...], ...] = ()


def turned_joints(record: Record, robot: Robot) -> TurnedJoints | None:
    """Find joints of which position, velocity and torque together have the sign opposite to the model.

    The couplings with other joints and their weights show it, not the torque of the joint alone, so that it does not
    show in an arm without either. The sign and the size of every effort are free, as are offset, friction and rotor.

    Args:
        record: The log, its torques those of the effort.
        robot: The model.

    Returns:
        The joints; None where as they are the model explains as much, or with a zero elsewhere by right angles more.
    """
    compared, M = EffortComparison.of(record, robot), robot.n_motors
    as_is = _shares(compared.at())
    if np.sum(np.log(as_is / LEAST)) < CLEAR:
        return None
    falls: dict[tuple[int, ...], float] = {(): 0.0}
    left: dict[tuple[int, ...], FloatArray] = {(): as_is}
    for motors in (each for n in range(1, min(MOST, M) + 1) for each in combinations(range(M), n)):
        left[motors] = _shares(compared.at(signs=np.where(np.isin(np.arange(M), motors), -1.0, 1.0)))
        falls[motors] = float(np.sum(np.log(as_is / left[motors])))
    clear = [motors for motors in falls if all(falls[motors] - falls[less] > CLEAR for less in _with_one_less(motors))]
    best = max(clear, key=lambda motors: falls[motors])
    if not best or left[best].mean() > min(MOST_LEFT, MOST_OF_BEFORE * as_is.mean()):
        return None
    elsewhere = (float(np.sum(np.log(as_is / _shares(compared.at(offset=zero))))) for zero in _zeros(robot))
    if any(fall > falls[best] + ALIKE for fall in elsewhere):
        return None
    alike = tuple(motors for motors in clear if motors != best and falls[motors] > falls[best] - ALIKE)
    return TurnedJoints(best, float(as_is.mean()), float(left[best].mean()), alike)


def _shares(compared: Sequence[Comparison]) -> FloatArray:
    return np.array([max(each.unexplained, LEAST) for each in compared])


def _with_one_less(motors: tuple[int, ...]) -> tuple[tuple[int, ...], ...]:
    return tuple(tuple(other for other in motors if other != motor) for motor in motors)


def _zeros(robot: Robot) -> list[FloatArray]:
    """List offsets of the zero of one joint by right angles [rad], each of shape (M,)."""
    turning = [k for k, motor in enumerate(robot.motors) if motor.rotary]
    return [np.radians(angle) * np.eye(robot.n_motors)[k] for k in turning for angle in RIGHT_ANGLES]
