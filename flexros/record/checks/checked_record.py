"""Results that the checks of a record share: its torque balance, and joint assignments that fit better."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.balance.joint_assignments import (
    DOUBTFUL,
    best_assignment,
    clearly_better,
    own_fits,
    own_score,
    score,
)
from flexros.record.balance.posture import Motion, postures
from flexros.record.balance.spectra import torque_balance
from flexros.record.balance.torque_balance import Delay
from flexros.record.missing_samples import bridged, bridged_motion
from flexros.record.quantization import encoder_step
from flexros.record.smoothing import noise_power, smooth_motion

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.record.balance.joint_assignments import JointAssignment
    from flexros.record.balance.posture import Posture
    from flexros.record.balance.torque_balance import BalanceFit, TorqueBalance
    from flexros.record.record import Record
    from flexros.robot import Robot

SAME_RATE = 0.1
"""Relative difference of two sample times up to which they count as equal (chosen)."""

STANDS_OUT = 10.0
"""Rms of the smooth motion over the noise of the encoder above which a motor moves (chosen)."""

ALIKE = float(np.log(2.0))
"""Sum of the logarithms of factors by which torques may be further off in another order that is the right one [1]
(chosen)."""

SWAPPED = float(np.log(3.0))
"""Mean logarithm of the factors by which less of the torques is unexplained in another order, from which it is the
right one [1] (chosen): 1.9 and more where two are swapped of drawn arms with hidden friction, rotors and loads."""

IN_PLACE = float(np.log(1.5))
"""The same with the opposite sign, from which another order is wrong, however well it agrees [1] (chosen)."""

FOREIGN = 0.3
"""Largest share of the power of a torque that is unexplained where it belongs [1] (chosen)."""

TINY = 1e-6
"""Share of the power of a torque below which numerical errors are left of it [1]."""

SLOW = 4.0
"""Frequency up to which the torque of the arm needs the whole motion [Hz] (chosen): weight and slow moves."""

MOST_SLOW = 400_000
"""Samples from which on every second, third ... one tells slow torques (chosen): 100 s at 4 kHz. A part of a torque is
several times as large as its log."""

FASTEST_LOOK = 50.0
"""Corner frequency of the low-pass for the motion [Hz] (chosen)."""


@dataclass(frozen=True, eq=False)
class CheckedRecord:
    """A record under check.

    Attributes:
        record: The record.
        robot: The nominal robot.
    """

    record: Record
    robot: Robot

    @cached_property
    def position(self) -> FloatArray:
        """Motor positions without holes [rad or m], shape (n, M)."""
        return bridged_motion(self.record.position, self.record.valid)

    @cached_property
    def motion(self) -> FloatArray:
        """Smooth positions, speeds and accelerations of the motors, shape (3, n, M)."""
        cutoff = min(FASTEST_LOOK, 0.1 / self.record.sample_time)
        return smooth_motion(self.position, self.record.sample_time, cutoff)

    @cached_property
    def moves(self) -> BoolArray:
        """Motors that move beyond noise and rounding of their encoder, shape (M,)."""
        rounding = np.array([encoder_step(self.record, motor) for motor in range(self.robot.n_motors)]) / np.sqrt(12)
        noise = np.maximum(np.sqrt(noise_power(self.position)), np.maximum(rounding, 1e-12))
        return np.asarray(np.std(self.motion[0], axis=0) > STANDS_OUT * noise)

    @cached_property
    def balance(self) -> TorqueBalance | None:
        """Torque against inverse-dynamics torque; None where the robot has no equilibrium near the motion."""
        return torque_balance(self.record, self.robot)

    @cached_property
    def own(self) -> tuple[BalanceFit | None, ...]:
        """Comparison of the torques of every motor, length M; None where its motion is not clear of noise."""
        fits = own_fits(self.balance, self.robot.n_motors)
        return tuple(fit if moves else None for fit, moves in zip(fits, self.moves.tolist(), strict=True))

    def rigid_torque(self, highest: float = SLOW) -> FloatArray:
        """Torque that the rigid arm needs for the recorded motion [Nm or N], shape (n, M).

        Args:
            highest: Frequency up to which it is required [Hz].
        """
        return self._rigid_torques(highest)

    @cached_property
    def _rigid_torques(self) -> Callable[[float], FloatArray]:
        """Function of the frequency; several checks ask for the same one."""

        def torques(highest: float) -> FloatArray:
            return rigid_inverse_dynamics(self.robot, self.position, self.record.sample_time, highest)

        return cache(torques)

    @cached_property
    def over_all(self) -> tuple[FloatArray, FloatArray]:
        """Comparison of torques with those of the rigid arm over the whole motion.

        The spectra begin at several periods of a stretch, and every half octave counts alike. In a slow motion the
        weight is below them, and what is left is noise of the torque.

        The size is that over the torque of the bodies alone: viscous friction that a robot file states far too large,
        as the damping of a URDF that keeps a simulator stable, makes no torque small.

        Returns:
            How both agree without their means, -1 ... 1, and the size of the torque over that of the bodies, each of
            shape (M,).
        """
        record, tiny = self.record, np.finfo(float).tiny
        arm = self.rigid_torque()[record.valid]
        given = record.torque[record.valid]
        bodies = self._torque_of_bodies[record.valid]
        size = np.sqrt(np.mean(given**2, axis=0) / np.maximum(np.mean(bodies**2, axis=0), tiny))
        arm, given = arm - arm.mean(axis=0), given - given.mean(axis=0)
        agreement = 2 * np.sum(arm * given, axis=0) / np.maximum(np.sum(arm**2 + given**2, axis=0), tiny)
        return agreement, size

    @cached_property
    def _torque_of_bodies(self) -> FloatArray:
        """Torque that the rigid arm needs without the friction of its motors [Nm or N], shape (n, M)."""
        names = [f"{name}.viscous_friction" for name in self.robot.joint_names]
        return self.torque_without([name for name in names if name in self.robot.parameters])

    def torque_without(self, names: Iterable[str]) -> FloatArray:
        """Torque that the rigid arm would need without some numbers of the robot file [Nm or N], shape (n, M).

        Args:
            names: Names of the parameters that are zero then.
        """
        stated = [name for name in names if self.robot.parameters[name].value]
        if not stated:
            return self.rigid_torque()
        bare = self.robot.with_values(dict.fromkeys(stated, 0.0))
        return rigid_inverse_dynamics(bare, self.position, self.record.sample_time, SLOW)

    @property
    def slow_step(self) -> int:
        """Samples from one of `slow_samples` to the next, where all are valid."""
        return max(1, self.record.n_samples // MOST_SLOW)

    @property
    def slow_samples(self) -> IntArray:
        """Valid samples in which `slow_parts` are taken, shape (k,): of a long log every second, third ..."""
        return np.flatnonzero(self.record.valid)[:: self.slow_step]

    @cached_property
    def slow_parts(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Torques below `SLOW`, those that the rigid arm needs, and parts that a drive adds, in `slow_samples`.

        Parts are those of viscous and Coulomb friction, of a rotor, and an offset, of any size: shapes (k, M), (k, M)
        and (k, M, 4).
        """
        record, samples = self.record, self.slow_samples
        speed, acceleration = smooth_motion(self.position, record.sample_time, SLOW)[1:, samples]
        torque = smooth_motion(bridged(record.torque, record.valid), record.sample_time, SLOW)[0, samples]
        parts = np.stack([speed, np.sign(speed), acceleration, np.ones_like(speed)], axis=-1)
        return torque, self.rigid_torque()[samples], parts

    @cached_property
    def delay(self) -> Delay:
        """Delay of the torques with respect to their stamps."""
        return Delay(0.0, float("inf"), 0.0) if self.balance is None else self.balance.delay()

    @cached_property
    def unexplained(self) -> FloatArray:
        """Share of the power of each torque (rows) that the motion of each motor (columns) leaves, shape (M, M)."""
        M, balance = self.robot.n_motors, self.balance
        shares = np.ones((M, M))
        if balance is not None:
            for torque, motion in np.ndindex(*shares.shape):
                shares[torque, motion] = balance.unexplained(torque, motion)
        for motor in self.record.prescribed:  # without a torque, it is in its place
            shares[motor], shares[:, motor], shares[motor, motor] = 1.0, 1.0, 0.0
        return shares

    @cached_property
    def order(self) -> tuple[int, ...]:
        """Motor to whose motion each torque clearly belongs, length M; as they are unless another order is clear.

        Less must be unexplained in another order, whatever the model lacks. Near resonances, which dominate the power
        and which the model has elsewhere, nothing explains them; there the mean agreement over all frequencies counts.
        """
        M = self.robot.n_motors
        as_they_are = tuple(range(M))
        if self.balance is None or M < 2:
            return as_they_are
        explaining = _assigned(np.log(self.unexplained + TINY))
        elsewhere = np.array([self.unexplained[k, motion] for k, motion in enumerate(explaining) if k != motion])
        if self._fall(explaining) > SWAPPED and np.all(elsewhere < FOREIGN):
            return explaining
        agreements = _agreements(self.balance, M)
        for motor in self.record.prescribed:
            agreements[motor], agreements[:, motor], agreements[motor, motor] = 0.0, 0.0, 1.0
        agreeing = _assigned(-agreements)
        swapped = _agrees_better(self.balance, agreements, agreeing) and self._fall(agreeing) > -IN_PLACE
        return agreeing if swapped else as_they_are

    @property
    def order_is_wrong(self) -> bool:
        """Whether the torques clearly belong to the motions of other motors."""
        return self.order != tuple(range(self.robot.n_motors))

    def _fall(self, order: tuple[int, ...]) -> float:
        """Return the mean logarithm of the factors by which less of the torques is unexplained in another order [1]."""
        moved = [torque for torque, motion in enumerate(order) if torque != motion]
        falls = [np.log((self.unexplained[k, k] + TINY) / (self.unexplained[k, order[k]] + TINY)) for k in moved]
        return float(np.mean(falls)) if falls else 0.0

    @cached_property
    def assignment(self) -> JointAssignment | None:
        """Assignment with joints inverted or two exchanged that fits better; None without one."""
        if self.order_is_wrong or self.fits_nominal_rate:
            return None
        return best_assignment(self.record, self.robot, score(self.own))

    @property
    def wrongly_assigned(self) -> bool:
        """Whether another assignment fits so much better that no effect explains the difference."""
        return self.assignment is not None and self.assignment.clear

    @cached_property
    def postures(self) -> tuple[Posture, ...]:
        """Other directions of gravity or zeros of joints that explain far more; none where other signs do."""
        if self.order_is_wrong or self.fits_nominal_rate:
            return ()
        if self.assignment is not None and self.assignment.clear and not self.assignment.zeros:
            return ()
        told = np.std(self.record.torque[self.record.valid], axis=0) > 0  # those prescribed have none
        return postures(Motion(self.record, self.robot, self.position, self.motion, self.moves & told, SLOW))

    @cached_property
    def fits_nominal_rate(self) -> bool:
        """Whether the log fits the nominal sample time far better than that of its stamps."""
        current, nominal = score(self.own), self.robot.sample_time
        if current is None or current > DOUBTFUL or abs(self.record.sample_time / nominal - 1) < SAME_RATE:
            return False
        other = own_score(torque_balance(self.record, self.robot, nominal), self.robot.n_motors)
        return clearly_better(other, current)


def _assigned(costs: FloatArray) -> tuple[int, ...]:
    """Return the column of each row with the least sum of costs, shape (M, M)."""
    from scipy.optimize import linear_sum_assignment  # here, because it loads slowly

    return tuple(int(column) for column in linear_sum_assignment(costs)[1])


def _agrees_better(balance: TorqueBalance, agreements: FloatArray, order: tuple[int, ...]) -> bool:
    """Return whether torques agree clearly better with what the motions of other motors need.

    Loads of neighbouring joints vary alike, so that the torque of one may agree well with a multiple of what the
    other one needs. A torque that belongs there is not many times as large.
    """
    moved = [torque for torque, motion in enumerate(order) if torque != motion]
    if not moved:
        return False
    other, current = (
        float(np.mean([agreements[k, motion[k]] for k in moved])) for motion in (order, range(len(order)))
    )
    if not clearly_better(other, current):
        return False
    elsewhere, here = (_off_by(balance, {k: motion[k] for k in moved}) for motion in (order, range(len(order))))
    return elsewhere < here + ALIKE


def _off_by(balance: TorqueBalance, motions: Mapping[int, int]) -> float:
    """Return by what factors torques are off those that the motions of some motors need: sum of their logarithms."""
    fits = [balance.fit(torque, motion) for torque, motion in motions.items()]
    return float(sum(abs(np.log(abs(fit.factor))) for fit in fits if fit is not None))


def _agreements(balance: TorqueBalance, n_motors: int) -> FloatArray:
    """Agreement of each torque (rows) with each inverse-dynamics torque (columns), shape (M, M)."""
    A = np.zeros((n_motors, n_motors))
    for torque, motion in np.ndindex(*A.shape):
        fit = balance.fit(torque, motion)
        A[torque, motion] = 0.0 if fit is None else fit.agreement
    return A
