"""What the checks of a record share: its balance of torques, and other ways to read it that fit better."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.balance_spectra import torque_balance
from flexros.gap.rough_signals import bridged
from flexros.gap.torque_balance import Delay

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.record import GapRecord
    from flexros.gap.torque_balance import Fit, TorqueBalance
    from flexros.robot import Robot

CLEARLY = 0.3
"""Gain in mean agreement from which another reading of a log is believed (chosen)."""

DOUBTFUL = 0.55
"""Mean agreement below which other readings are tried (chosen)."""

SAME_RATE = 0.1
"""Relative difference of two sample times up to which they count as the same (chosen)."""


@dataclass(frozen=True, eq=False)
class CheckedRecord:
    """A record that is looked at.

    Attributes:
        record: The record.
        robot: The nominal robot.
    """

    record: GapRecord
    robot: Robot

    @cached_property
    def position(self) -> FloatArray:
        """Motor positions without holes [rad or m], shape (n, M)."""
        return bridged(self.record.position, self.record.valid)

    @cached_property
    def balance(self) -> TorqueBalance | None:
        """Torque against need; None where the robot has no rest near the motion."""
        return torque_balance(self.record, self.robot)

    @cached_property
    def own(self) -> tuple[Fit | None, ...]:
        """Torque of every motor beside its own need, length M; None where nothing can be told."""
        return _own(self.balance, self.robot.n_motors)

    @cached_property
    def delay(self) -> Delay:
        """Time by which torques act later than they are stamped."""
        return Delay(0.0, float("inf"), 0.0) if self.balance is None else self.balance.delay()

    @cached_property
    def order(self) -> tuple[int, ...]:
        """Motor whose motion agrees best with each torque, length M."""
        M, balance = self.robot.n_motors, self.balance
        if balance is None or M < 2:
            return tuple(range(M))
        from scipy.optimize import linear_sum_assignment  # here, because it loads slowly

        return tuple(int(motion) for motion in linear_sum_assignment(-_agreements(balance, M))[1])

    @cached_property
    def order_is_wrong(self) -> bool:
        """Whether the torques clearly belong to the motions of other motors."""
        M = self.robot.n_motors
        if self.balance is None or self.order == tuple(range(M)):
            return False
        A = _agreements(self.balance, M)
        moved = [torque for torque, motion in enumerate(self.order) if torque != motion]
        return float(np.mean([A[k, self.order[k]] - A[k, k] for k in moved])) > CLEARLY

    @cached_property
    def swapped_joints(self) -> tuple[int, int] | None:
        """Two motors that have to be exchanged, torque and position, for the log to fit; None without such."""
        M = self.robot.n_motors
        here = score(self.own)
        if M < 2 or here is None or here > DOUBTFUL or self.order_is_wrong:
            return None
        best, found = here + CLEARLY, None
        for pair in combinations(range(M), 2):
            order = np.arange(M)
            order[list(pair)] = order[list(pair[::-1])]
            other = replace(self.record, position=self.record.position[:, order], torque=self.record.torque[:, order])
            there = score(_own(torque_balance(other, self.robot), M))
            if there is not None and there > best:
                best, found = there, pair
        return found

    @cached_property
    def fits_nominal_rate(self) -> bool:
        """Whether the log fits the nominal sample time far better than that of its stamps."""
        here, nominal = score(self.own), self.robot.sample_time
        if here is None or here > DOUBTFUL or abs(self.record.sample_time / nominal - 1) < SAME_RATE:
            return False
        there = score(_own(torque_balance(self.record, self.robot, nominal), self.robot.n_motors))
        return there is not None and there > here + CLEARLY


def _own(balance: TorqueBalance | None, n_motors: int) -> tuple[Fit | None, ...]:
    return tuple(None if balance is None else balance.fit(k, k) for k in range(n_motors))


def _agreements(balance: TorqueBalance, n_motors: int) -> FloatArray:
    """Agreement of each torque (rows) with each need (columns), shape (M, M)."""
    A = np.zeros((n_motors, n_motors))
    for torque, motion in np.ndindex(*A.shape):
        fit = balance.fit(torque, motion)
        A[torque, motion] = 0.0 if fit is None else fit.agreement
    return A


def score(fits: Sequence[Fit | None]) -> float | None:
    """Mean agreement with the need itself, over the motors of which something can be told.

    Args:
        fits: Torque of every motor beside its own need.

    Returns:
        The mean; None where nothing can be told.
    """
    told = [max(fit.as_is, -1.0) for fit in fits if fit is not None]
    return float(np.mean(told)) if told else None
