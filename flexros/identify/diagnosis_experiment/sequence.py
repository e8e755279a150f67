"""Consecutive motions of the gears, each from rest to rest and of whole samples."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flexros.trajectory import JointMove, Move, Rest, bang_bang_snap, joint_limits
from flexros.trajectory.time_law import rest

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.diagnosis_experiment.specification import DiagnosisSpecification
    from flexros.identify.diagnosis_experiment.vibrations import Vibrations
    from flexros.trajectory.time_law import TimeLaw
    from flexros.trajectory.vibration import Vibration

JERK_TIMES = (0.08, 0.2)
"""Range of times in which a fast move reaches its acceleration [s] (chosen)."""
SNAP_SHARE = 0.5
"""Time in which it reaches its jerk as a share of the shortest of those [1] (chosen)."""
MOVE_SHARE = (0.6, 0.9)
"""Range of accelerations of a fast move as shares of the largest [1] (chosen)."""
POSE_SHARE = (0.25, 0.5)
"""Range of distances of a pose from the initial one as shares of the reach [1]; the rest is for parts (chosen)."""


@dataclass(eq=False)
class Sequence:
    """A motion that is extended at its end.

    Attributes:
        specification: Length, parts and sizes.
        vibrations: Factory of the periodic parts, with the sizes of the motion.
        random: Random generator.
        start: Initial gear angles [rad or m], shape (M,).
        poses: Gear angles of the poses of the parts, the initial one first [rad or m], shape (M,) each.
        current: Gear angles at the end [rad or m], shape (M,).
        moves: The motion so far.
        time: Its duration [s].
    """

    specification: DiagnosisSpecification
    vibrations: Vibrations
    random: np.random.Generator
    start: FloatArray
    poses: list[FloatArray] = field(init=False)
    current: FloatArray = field(init=False)
    moves: list[Move] = field(default_factory=list)
    time: float = 0.0

    def __post_init__(self) -> None:
        self.current = self.start
        self.poses = [self.start, *(self.pose() for _ in range(self.specification.poses - 1))]

    def pose(self) -> FloatArray:
        """Draw a pose, every joint away from its initial position, shape (M,)."""
        signs = self.random.choice([-1.0, 1.0], len(self.start))
        share = self.random.uniform(*POSE_SHARE, len(self.start))
        pose: FloatArray = self.start + signs * share * self.vibrations.scales.reach
        return pose

    def whole(self, time: float) -> float:
        """Round a time up to whole samples [s]."""
        return float(np.ceil(time / self.vibrations.sample_time - 1e-6) * self.vibrations.sample_time)

    def stay(self, time: float) -> None:
        """Rest for at least this time [s]."""
        self._add(Move(Rest(self.current), rest(self.whole(time))))

    def move(self, goal: FloatArray, law: TimeLaw, after: float = 0.0) -> None:
        """Move all joints simultaneously, then rest.

        Args:
            goal: Gear angles at the end [rad or m], shape (M,).
            law: Time law from 0 to 1.
            after: Smallest rest after it [s].
        """
        time = self.whole(law.duration + after)
        longer = law.held(after=time - law.duration) if time > law.duration else law
        self._add(Move(JointMove(self.current, goal), longer))

    def go(self, goal: FloatArray, dwell_share: float = 1.0) -> None:
        """Move fast to a goal, near the largest acceleration, and rest; nothing if the goal is the current pose.

        Args:
            goal: Gear angles at the end [rad or m], shape (M,).
            dwell_share: Rest after it as a share of the usual one [1].
        """
        if np.allclose(goal, self.current, rtol=0.0, atol=1e-12):
            return
        scales = self.vibrations.scales
        acceleration = self.specification.intensity * self.random.uniform(*MOVE_SHARE) * scales.acceleration
        jerk = acceleration / self.random.uniform(*JERK_TIMES)
        snap = jerk / (SNAP_SHARE * JERK_TIMES[0])
        limits = joint_limits(JointMove(self.current, goal), (scales.speed, acceleration, jerk, snap))
        self.move(goal, bang_bang_snap(1.0, limits), dwell_share * self.specification.dwell)

    def vibrate(self, vibration: Vibration) -> None:
        """Vibrate about the current pose; `vibration` has whole samples."""
        self._add(Move(vibration, vibration.law()))

    def _add(self, move: Move) -> None:
        self.moves.append(move)
        self.time += move.law.duration
        self.current = move.path.point_at(move.law.end)
