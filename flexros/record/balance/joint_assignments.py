"""Other ways to read a record - a joint inverted, two exchanged - and whether one of them fits the robot far better."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.balance.spectra import torque_balance

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.arrays import FloatArray
    from flexros.record.balance.torque_balance import BalanceFit, TorqueBalance
    from flexros.record.record import Record
    from flexros.robot import Robot

DOUBTFUL = 0.9
"""Mean agreement below which other readings are tried (chosen)."""

GAIN, REST = 0.1, 0.4
"""By how much the mean agreement must grow, and to which share the disagreement must shrink, for another reading to be
believed (chosen)."""

LONG = 16.0
"""Length of the part of a record with which readings are compared where there are many motors [s] (chosen)."""

FEW = 3
"""Motors up to which the whole record is used (chosen)."""


@dataclass(frozen=True)
class JointAssignment:
    """Another way to read a record.

    Attributes:
        text: What is wrong with the log if it is the right one.
        agreement: Mean agreement of torques and needs with it.
    """

    text: str
    agreement: float


def own_fits(balance: TorqueBalance | None, n_motors: int) -> tuple[BalanceFit | None, ...]:
    """Compare the torque of every motor with its own need.

    Args:
        balance: Torques and needs; None where there are none.
        n_motors: Number of motors M.

    Returns:
        Comparisons, length M; None where nothing can be told.
    """
    return tuple(None if balance is None else balance.fit(k, k) for k in range(n_motors))


def score(fits: Sequence[BalanceFit | None]) -> float | None:
    """Mean agreement with the need itself, over the motors of which something can be told.

    Args:
        fits: Torque of every motor beside its own need.

    Returns:
        The mean; None where nothing can be told.
    """
    told = [max(fit.as_is, -1.0) for fit in fits if fit is not None]
    return float(np.mean(told)) if told else None


def clearly_better(there: float | None, here: float | None) -> bool:
    """Tell whether one mean agreement is so much better than another that no effect makes the difference.

    Args:
        there: Mean agreement that may be better; None where nothing can be told.
        here: Mean agreement now.

    Returns:
        Whether it is.
    """
    if there is None or here is None:
        return False
    return there > here + GAIN and 1 - there < REST * (1 - here)


def best_reading(record: Record, robot: Robot, here: float | None) -> JointAssignment | None:
    """Find a reading that fits clearly better than the record as it is.

    Args:
        record: The record.
        robot: The nominal robot.
        here: Mean agreement of the record as it is.

    Returns:
        The best one; None where the record fits well, or no reading does.
    """
    if here is None or here > DOUBTFUL:
        return None
    if robot.n_motors > FEW and record.duration > LONG:
        record = _liveliest(record, round(LONG / record.sample_time))
        here = score(own_fits(torque_balance(record, robot), robot.n_motors))
    found = [reading for reading in _readings(record, robot) if clearly_better(reading.agreement, here)]
    return max(found, key=lambda reading: reading.agreement) if found else None


def _liveliest(record: Record, length: int) -> Record:
    """Cut out the part in which the torques vary most."""
    starts = np.arange(0, record.n_samples - length, max(1, length // 4))
    scale = np.maximum(record.torque.std(axis=0), 1e-300)
    lively = [np.sum(record.torque[k : k + length].std(axis=0) / scale) for k in starts]
    first = int(starts[int(np.argmax(lively))])
    return record.part(first, first + length)


def _readings(record: Record, robot: Robot) -> Iterator[JointAssignment]:
    """Try torques and positions in other directions and orders, both alike or one of them."""
    M, names = robot.n_motors, robot.joint_names
    as_is = torque_balance(record, robot)
    for k in range(M):
        sign = np.ones(M)
        sign[k] = -1.0
        agreement = None if as_is is None else score(own_fits(replace(as_is, given=sign * as_is.given), M))
        if agreement is not None:
            yield JointAssignment(f"the torque of {names[k]} inverted", agreement)
        yield from _both(record, robot, np.arange(M), sign, f"of {names[k]} inverted")
    for i, j in combinations(range(M), 2):
        order = np.arange(M)
        order[[i, j]] = order[[j, i]]
        yield from _both(record, robot, order, np.ones(M), f"of {names[i]} and {names[j]} exchanged")


def _both(record: Record, robot: Robot, order: np.ndarray, sign: FloatArray, change: str) -> Iterator[JointAssignment]:
    """Change the positions, and with them the torques or not."""
    M = robot.n_motors
    changed = replace(record, position=sign * record.position[:, order], torque=sign * record.torque[:, order])
    balance = torque_balance(changed, robot)
    if balance is None:
        return
    kept = replace(balance, given=(sign * balance.given)[:, np.argsort(order)])
    for one, what in ((balance, "torque and position"), (kept, "the position")):
        agreement = score(own_fits(one, M))
        if agreement is not None:
            yield JointAssignment(f"{what} {change}", agreement)
