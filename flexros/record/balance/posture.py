"""Direction of gravity and zeros of the joints that torques show, where the robot file and the mapping say others.

A base hangs from a ceiling, is fixed to a wall or stands at a slant, or its frame is turned; two models of a robot
count their joints from different poses. The torque of the arm is that of another posture then. What it leaves of them
is compared over time, beside what every motor has of its own: an offset, both frictions and a rotor. So slow moves,
which show little but weight, count as much as others.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.balance.inverse_dynamics import SlowMotion
from flexros.record.balance.regression import coefficients
from flexros.robot.parameters import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.record.record import Record
    from flexros.robot import Robot

STANDARD = 9.81
"""Size of gravity where a robot file has none [m/s2]."""

CARRIES = 0.3
"""Change of the weight, beside what a motor has of its own, over the torque, both rms, from which the weight shows in
it [1] (chosen): as much as what must be left as stated."""

FEWEST = 2
"""Fewest motors that carry weight (chosen): at one of them a spring may balance it, and a zero may be anywhere."""

LOST = 0.3
"""Least rest of the torques as stated, over the torques, both rms [1] (chosen): what a slant of the base of about 17
deg leaves. Less is an error of the model, to be diagnosed."""

LESS = 0.5
"""Largest rest in another posture, over that as stated [1] (chosen): wrong masses, centres of mass and loads leave
more in any posture."""

LIGHTEST, HEAVIEST = 0.5, 2.0
"""Smallest and largest size of the gravity that is found, over that which is stated (chosen): masses may be off by as
much, and torques without the weight show none at all."""

IN_LINE = 5.0
"""Largest angle to an axis of the base up to which gravity counts as along it [deg] (chosen)."""

ALIKE = 1.25
"""Rest over the smallest one up to which another posture is told too [1] (chosen)."""

BETTER = 0.9
"""Largest rest with a further zero turned, over that before, for which the zero counts as turned [1] (chosen)."""

RIGHT_ANGLES = (90.0, -90.0, 180.0)
"""Differences between the zeros of two models of a robot that are tried [deg]."""

DRIVES = -0.01
"""Mean power of the fitted friction over the product of rms torque and speed, below which it drives the motion [1]
(chosen): torques of the other sign imitate a base upside down so."""

MOST_SAMPLES = 200_000
"""Most samples that are compared, spread evenly over a longer record (chosen): weight changes slowly."""


@dataclass(frozen=True, eq=False)
class Posture:
    """Another posture of the arm.

    Attributes:
        gravity: Gravity in the frame of the base [m/s2], shape (3,).
        turned: Angles that belong to the positions of the log [deg], shape (M,).
        carrying: Motors whose torque has much of the weight in it, shape (M,).
        rest: What the posture leaves of their torques, with gravity of any size, over these torques, in rms [1].
        stated: The same as stated.
        of_all: The same of the torques of all motors that move, in this posture [1].
    """

    gravity: FloatArray
    turned: FloatArray
    carrying: BoolArray
    rest: float
    stated: float
    of_all: float

    def told(self, joints: Sequence[str]) -> str:
        """Return what to change, with the names of the joints."""
        if not self.turned.any():
            numbers = ", ".join(f"{component:.4g}" for component in self.gravity.round(2) + 0.0)
            return f"'gravity: [{numbers}]' in the robot file (how the base is mounted)"
        turned = zip(joints, self.turned.tolist(), strict=True)
        angles = ", ".join(f"{angle:+g} deg at {name}" for name, angle in turned if angle)
        return f"{angles} added to the positions (offset in the mapping)"


@dataclass(frozen=True, eq=False)
class Motion:
    """A record as the comparison needs it.

    Attributes:
        record: The record.
        robot: The nominal robot.
        position: Motor positions without holes [rad or m], shape (n, M).
        smooth: Smooth positions, speeds and accelerations, shape (3, n, M).
        moves: Motors that move, shape (M,).
        highest: Frequency up to which the torque of the arm is required [Hz].
    """

    record: Record
    robot: Robot
    position: FloatArray
    smooth: FloatArray
    moves: BoolArray
    highest: float

    @cached_property
    def samples(self) -> IntArray:
        """Samples that are compared: the valid ones, or some of them, shape (k,)."""
        valid = np.flatnonzero(self.record.valid)
        return valid[:: -(-len(valid) // MOST_SAMPLES) or 1]

    @property
    def given(self) -> FloatArray:
        """Torques at these samples [Nm or N], shape (k, M)."""
        return self.record.torque[self.samples]

    def arm(self, gravity: FloatArray, turned: FloatArray) -> FloatArray:
        """Torque of the bodies at these samples [Nm or N], shape (k, M), with positions turned by angles [deg]."""
        robot = self._under(tuple(gravity.tolist()))
        return self._slow.torque(robot, np.radians(turned))[self.samples]

    @cached_property
    def _slow(self) -> SlowMotion:
        """The motion that all postures share but for constant angles."""
        return SlowMotion.of(self.position, self.record.sample_time, self.highest)

    @cached_property
    def _under(self) -> Callable[[tuple[float, ...]], Robot]:
        """Function of gravity [m/s2]: the robot under it; all postures are tried under the same few."""
        return cache(lambda gravity: self.robot.with_values(dict(zip(GRAVITY, gravity, strict=True))))

    def own(self, motor: int) -> FloatArray:
        """Offset, speed, its sign and acceleration of a motor at these samples, shape (k, 4)."""
        speed, acceleration = self.smooth[1:, self.samples, motor]
        return np.column_stack([np.ones_like(speed), speed, np.sign(speed), acceleration])


def postures(motion: Motion) -> tuple[Posture, ...]:
    """Find postures that explain the torques far better than that of robot file and mapping.

    Args:
        motion: The record.

    Returns:
        The best one, and those that are hardly worse; none where the stated one explains as much.
    """
    stated = np.array(motion.robot.spec.gravity.value, dtype=float)
    size = float(np.linalg.norm(stated)) or STANDARD
    as_is = _Weights.of(motion, np.zeros(len(motion.moves)), np.eye(3))
    if as_is is None:
        return ()
    others = [_mounted_otherwise(as_is, size)]
    if np.any(stated) and as_is.left(stated) > LOST * np.sqrt(FEWEST / len(as_is.rest)):
        others.append(_counted_otherwise(motion, as_is))
    found = [one for one in others if one is not None and _far_better(motion, one)]
    least = min((one.of_all for one in found), default=0.0)
    return tuple(sorted((one for one in found if one.of_all <= ALIKE * least), key=lambda one: one.of_all))


def _far_better(motion: Motion, one: Posture) -> bool:
    """Return whether a posture explains far more, and no friction that drives the motion is needed for it."""
    if one.carrying.sum() < FEWEST or one.stated < LOST or one.rest > LESS * one.stated:
        return False
    arm = motion.arm(one.gravity, one.turned)
    given = motion.given
    for motor in np.flatnonzero(one.carrying):
        own = motion.own(int(motor))
        friction = own[:, 1:3] @ coefficients(own, given[:, motor] - arm[:, motor])[1:3]
        if np.mean(friction * own[:, 1]) < DRIVES * np.std(given[:, motor]) * np.std(own[:, 1]):
            return False
    return True


def _mounted_otherwise(as_is: _Weights, size: float) -> Posture | None:
    """Fit the vector of gravity, in which the torques are linear."""
    solution = coefficients(as_is.weight.reshape(-1, 3), as_is.rest.ravel())
    length = float(np.linalg.norm(solution))
    if not LIGHTEST * size < length < HEAVIEST * size:
        return None
    return as_is.posture(as_is, solution, size * _in_line(solution / length), np.zeros(len(as_is.moves)))


def _counted_otherwise(motion: Motion, as_is: _Weights) -> Posture | None:
    """Turn the zero of one joint after the other by right angles, each time that of the joint that improves most."""
    rotary = [k for k, motor in enumerate(motion.robot.motors) if motor.position_unit == "rad"]
    turned, reached, best = np.zeros(len(as_is.moves)), np.inf, None
    along = as_is.stated[None] / np.linalg.norm(as_is.stated)
    while True:
        trials = []
        for joint in (k for k in rotary if turned[k] == 0):
            for angle in RIGHT_ANGLES:
                trial = np.where(np.arange(len(turned)) == joint, angle, turned)
                weights = _Weights.of(motion, trial, along)
                if weights is None:
                    continue
                trials.append((weights.left(as_is.stated), joint, angle, weights))
        if not trials:
            return best
        left, joint, angle, weights = min(trials, key=lambda trial: trial[:3])
        if left > BETTER * reached:
            return best
        reached, turned = left, np.where(np.arange(len(turned)) == joint, angle, turned)
        best = weights.posture(as_is, as_is.stated, as_is.stated, turned)


@dataclass(frozen=True, eq=False)
class _Weights:
    """Torques without what each motor has of its own, over their rms, of the K motors that move.

    Attributes:
        rest: Torques without those of the weightless bodies [1], shape (K, k).
        weight: Torques of the weight by gravity along each axis [s2/m], shape (K, k, 3);
            directions that were not tried add nothing.
        moves: Motors that move, shape (M,).
        stated: Gravity in the robot file [m/s2], shape (3,).
    """

    rest: FloatArray
    weight: FloatArray
    moves: BoolArray
    stated: FloatArray

    @classmethod
    def of(cls, motion: Motion, turned: FloatArray, directions: FloatArray) -> _Weights | None:
        """Compare torques with those of the bodies.

        Args:
            motion: The record.
            turned: Angles by which its positions are turned [deg], shape (M,).
            directions: Directions in which gravity is tried, orthogonal, of length one, shape (k, 3).

        Returns:
            The torques; None where nothing moves.
        """
        bodies = motion.arm(np.zeros(3), turned)
        weight = np.stack([motion.arm(axis, turned) - bodies for axis in directions], axis=2) @ directions
        given = motion.given
        rests, weights = [], []
        for motor in np.flatnonzero(motion.moves):
            size = max(float(np.std(given[:, motor])), 1e-300)
            columns = np.column_stack([(given - bodies)[:, motor], weight[:, motor]]) / size
            own = motion.own(int(motor))
            columns = columns - own @ np.column_stack([coefficients(own, column) for column in columns.T])
            rests.append(columns[:, 0])
            weights.append(columns[:, 1:])
        stated = np.array(motion.robot.spec.gravity.value, dtype=float)
        return cls(np.array(rests), np.array(weights), motion.moves, stated) if rests else None

    def posture(self, as_is: _Weights, gravity: FloatArray, told: FloatArray, turned: FloatArray) -> Posture:
        """Compare a posture with that as stated.

        Args:
            as_is: Torques and weights as stated.
            gravity: Gravity, in any size [m/s2], shape (3,).
            told: The same as it is told [m/s2], shape (3,).
            turned: Angles of the posture [deg], shape (M,).
        """
        chosen = np.std(self.weight @ gravity, axis=1) > CARRIES
        carrying = np.zeros(len(self.moves), dtype=bool)
        carrying[self.moves] = chosen
        return Posture(
            told, turned, carrying, self.left(gravity, chosen), as_is.left(as_is.stated, chosen), self.left(gravity)
        )

    def left(self, gravity: FloatArray, chosen: BoolArray | None = None) -> float:
        """Return the rest of torques, by default of all, in rms, with the size of gravity that leaves least [1]."""
        rest, along = (
            (self.rest, self.weight @ gravity) if chosen is None else (self.rest[chosen], self.weight[chosen] @ gravity)
        )
        size = max(float(np.vdot(along, rest)) / max(float(np.vdot(along, along)), 1e-300), 0.0)
        return float(np.sqrt(np.mean((rest - size * along) ** 2))) if rest.size else 0.0


def _in_line(direction: FloatArray) -> FloatArray:
    """Return the axis of the base that a direction is close to, else the direction."""
    axis = int(np.argmax(np.abs(direction)))
    if abs(direction[axis]) < np.cos(np.radians(IN_LINE)):
        return direction
    return np.asarray(np.sign(direction[axis]) * np.eye(3)[axis])
