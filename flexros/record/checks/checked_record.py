"""What the checks of a record share: its balance of torques, and other ways to read it that fit better."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.balance.joint_assignments import DOUBTFUL, best_reading, clearly_better, own_fits, score
from flexros.record.balance.spectra import torque_balance
from flexros.record.balance.torque_balance import Delay
from flexros.record.smoothing import bridged

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.balance.joint_assignments import JointAssignment
    from flexros.record.balance.torque_balance import BalanceFit, TorqueBalance
    from flexros.record.record import Record
    from flexros.robot import Robot

SAME_RATE = 0.1
"""Relative difference of two sample times up to which they count as the same (chosen)."""


@dataclass(frozen=True, eq=False)
class CheckedRecord:
    """A record that is looked at.

    Attributes:
        record: The record.
        robot: The nominal robot.
    """

    record: Record
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
    def own(self) -> tuple[BalanceFit | None, ...]:
        """Torque of every motor beside its own need, length M; None where nothing can be told."""
        return own_fits(self.balance, self.robot.n_motors)

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
        there, here = (float(np.mean([A[k, place[k]] for k in moved])) for place in (self.order, range(M)))
        return clearly_better(there, here)

    @cached_property
    def reading(self) -> JointAssignment | None:
        """Another reading of the record, a joint inverted or two exchanged, that fits far better; None without such."""
        if self.order_is_wrong or self.fits_nominal_rate:
            return None
        return best_reading(self.record, self.robot, score(self.own))

    @cached_property
    def fits_nominal_rate(self) -> bool:
        """Whether the log fits the nominal sample time far better than that of its stamps."""
        here, nominal = score(self.own), self.robot.sample_time
        if here is None or here > DOUBTFUL or abs(self.record.sample_time / nominal - 1) < SAME_RATE:
            return False
        there = score(own_fits(torque_balance(self.record, self.robot, nominal), self.robot.n_motors))
        return clearly_better(there, here)


def _agreements(balance: TorqueBalance, n_motors: int) -> FloatArray:
    """Agreement of each torque (rows) with each need (columns), shape (M, M)."""
    A = np.zeros((n_motors, n_motors))
    for torque, motion in np.ndindex(*A.shape):
        fit = balance.fit(torque, motion)
        A[torque, motion] = 0.0 if fit is None else fit.agreement
    return A
