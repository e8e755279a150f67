"""The course of a diagnosis experiment: its parts in the order of time, as one trajectory of the gears."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.gap_experiment.scales import Scales, scales_of
from flexros.identify.gap_experiment.specification import WEIGHTS, DiagnosisSpecification
from flexros.identify.gap_experiment.vibrations import FADE, Vibrations
from flexros.random_streams import Stream, generator
from flexros.trajectory import JOINTS, JointMove, Limits, Move, Rest, Trajectory, bang_bang_snap, joint_limits
from flexros.trajectory.polynomial import ninth_degree
from flexros.trajectory.time_law import rest

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.identify.gap_experiment.specification import PartName
    from flexros.robot import Robot
    from flexros.trajectory.time_law import TimeLaw
    from flexros.trajectory.vibration import Vibration

PARTS_STREAM = 2
"""Number of the random stream of the experiment among those of excitations."""
FIRST_REST = 1.2
"""Rest at the start [s] (chosen)."""
DWELL = 0.3
"""Rest after a move [s] (chosen)."""
LAST_REST = 0.5
"""Rest at the end [s] (chosen)."""
WAY_BACK = 1.0
"""Time set aside for the way back to the start [s] (chosen)."""
JERK_TIMES = (0.08, 0.2)
"""Time in which a fast move reaches its acceleration, from and to [s] (chosen)."""
MOVE_SHARE = (0.6, 0.9)
"""Acceleration of a fast move as a share of the largest, from and to [1] (chosen)."""
STEP_TIMES = (0.03, 0.06, 0.12)
"""Times of the steps [s] (chosen)."""
STEP_SHARE = 0.5
"""Largest acceleration of a step as a share of that of a move [1] (chosen)."""


@dataclass(frozen=True)
class Part:
    """A part of the experiment.

    Attributes:
        name: What it is, e.g. "creep".
        begin: Time of its begin [s].
        end: Time of its end [s].
    """

    name: str
    begin: float
    end: float


@dataclass(frozen=True, eq=False)
class Course:
    """What happens when.

    Attributes:
        trajectory: Gear motion; every move takes whole samples.
        parts: Its parts in the order of time.
        scales: Sizes of the motion.
    """

    trajectory: Trajectory
    parts: tuple[Part, ...]
    scales: Scales


def diagnosis_course(
    specification: DiagnosisSpecification,
    robot: Robot,
    law: AbstractControlLaw,
    sample_time: float,
    seed: int,
    arm: FloatArray,
) -> Course:
    """Make the diagnosis experiment of a robot; it depends on these arguments alone.

    Args:
        specification: What was asked for.
        robot: The nominal robot.
        law: The feedback controller.
        sample_time: Time between two samples [s].
        seed: Seed where the specification has none of its own.
        arm: Arm coordinates at the start [rad or m], shape (N,).

    Returns:
        The course.

    Raises:
        InputError: Settings and robot do not go together.
    """
    own = seed if specification.seed is None else specification.seed
    random = generator(own, Stream.EXCITATION, PARTS_STREAM)
    scales = scales_of(specification, robot, arm)
    vibrations = Vibrations(robot, arm, law, sample_time, scales)
    begin = arm[list(robot.chain.geared)]
    builder = _Builder(specification, vibrations, random, begin)
    return builder.course()


@dataclass(eq=False)
class _Builder:
    """Puts parts one after the other."""

    specification: DiagnosisSpecification
    vibrations: Vibrations
    random: np.random.Generator
    begin: FloatArray
    moves: list[Move] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)
    time: float = 0.0

    def course(self) -> Course:
        """Put all parts one after the other."""
        self.here, self.scales = self.begin, self.vibrations.scales
        poses = [self.begin, *(self._pose() for _ in range(self.specification.poses - 1))]
        order: list[PartName] = [
            self.specification.parts[k] for k in self.random.permutation(len(self.specification.parts))
        ]
        total = sum(WEIGHTS[name] for name in order)
        left = max(self.specification.length - FIRST_REST - LAST_REST - WAY_BACK, 0.5 * self.specification.length)
        self._rest(FIRST_REST)
        for number, name in enumerate(order):
            start = self.time
            self._go(poses[number % len(poses)])
            time = left * WEIGHTS[name] / total - (self.time - start)
            before = self.time
            getattr(self, f"_{name}")(max(time, 0.3), poses)
            self.parts.append(Part(name, before, self.time))
        self._go(self.begin)
        self._rest(LAST_REST)
        return Course(Trajectory(tuple(self.moves), JOINTS), tuple(self.parts), self.scales)

    def _pose(self) -> FloatArray:
        """Draw a pose, every joint between half and the whole of its reach from the start."""
        size = self.random.uniform(0.5, 1.0, len(self.begin)) * self.random.choice([-1.0, 1.0], len(self.begin))
        pose: FloatArray = self.begin + 0.5 * size * self.scales.reach
        return pose

    def _add(self, move: Move) -> None:
        """Append a move."""
        self.moves.append(move)
        self.time += move.law.duration
        self.here = move.path.point_at(move.law.end)

    def _rest(self, time: float) -> None:
        """Stay for whole samples."""
        begin = self.time
        self._add(Move(Rest(self.here), rest(self._whole(time))))
        self.parts.append(Part("standstill", begin, self.time))

    def _whole(self, time: float) -> float:
        """Round up to whole samples."""
        return float(np.ceil(time / self.vibrations.sample_time - 1e-6) * self.vibrations.sample_time)

    def _move(self, goal: FloatArray, law_of: TimeLaw, after: float = 0.0) -> None:
        """Append a move of all joints with its rest, in whole samples."""
        time = self._whole(law_of.duration + after)
        law = law_of.held(after=time - law_of.duration) if time > law_of.duration else law_of
        self._add(Move(JointMove(self.here, goal), law))

    def _go(self, goal: FloatArray, dwell: float = DWELL) -> None:
        """Move fast to a goal, near the largest accelerations, and rest."""
        if np.allclose(goal, self.here, atol=1e-12):
            return
        share = self.specification.intensity * self.random.uniform(*MOVE_SHARE)
        acceleration = share * self.scales.acceleration
        jerk = acceleration / self.random.uniform(*JERK_TIMES)
        limits = joint_limits(
            JointMove(self.here, goal), (self.scales.speed, acceleration, jerk, jerk / (0.5 * JERK_TIMES[0]))
        )
        self._move(goal, bang_bang_snap(1.0, limits), dwell)

    # Parts; each begins and ends at rest in the pose where it is.

    def _creep(self, time: float, poses: list[FloatArray]) -> None:
        """Creep there and back at several speeds; those slower than the first go a shorter way in its time."""
        speeds = np.array(self.specification.creep_speeds)
        legs = 1.0 / np.maximum(speeds / speeds[0], 1.0)
        legs = np.where(speeds < speeds[0], 1.0 / 3.0, legs)
        leg_times = 0.5 * time * legs / np.sum(legs)
        centre = self.here
        for speed, leg in zip(speeds / speeds[0], leg_times, strict=True):
            ramp = 0.15 * leg
            rate = 1.0 / (leg - ramp)
            room = 0.5 * self.scales.acceleration / (1.5 * rate / ramp)
            way = np.minimum(self.scales.creep * min(1.0, speed * leg / leg_times[0]), room)
            way = way * self.random.choice([-1.0, 1.0], len(way))
            limits = Limits(rate, 1.5 * rate / ramp, 6.0 * rate / ramp**2, 60.0 * rate / ramp**3)
            for goal in (centre + way, centre):
                self._move(goal, bang_bang_snap(1.0, limits))

    def _presliding(self, time: float, poses: list[FloatArray]) -> None:
        """Reverse slowly with three small amplitudes."""
        largest = np.maximum(0.1 * self.scales.creep, self.scales.smallest)
        for size in np.geomspace(self.scales.smallest, largest, 3):
            self._vibrate(self.vibrations.slow(self.here, self._whole(time / 3.0), size, self.random))

    def _multisine(self, time: float, poses: list[FloatArray]) -> None:
        """Multisines of rising size, the last one in another pose."""
        levels = self.specification.levels
        for number, level in enumerate(levels):
            if number and number == len(levels) - 1:
                self._go(poses[(len(poses) - 1)])
            self._excite(time / len(levels), level)

    def _biased(self, time: float, poses: list[FloatArray]) -> None:
        """Make a multisine of middle size on a slow swing."""
        self._excite(
            max(time, 8.0 * FADE),
            sorted(self.specification.levels)[len(self.specification.levels) // 2],
            self.specification.bias,
        )

    def _excite(self, time: float, level: float, bias: float = 0.0) -> None:
        size = self.specification.intensity
        self._vibrate(
            self.vibrations.multisine(
                self.here,
                max(time, 4.0 * FADE),
                size * level,
                self.random,
                self.specification.highest,
                size * bias,
            )
        )

    def _moves(self, time: float, poses: list[FloatArray]) -> None:
        """Move fast from pose to pose."""
        end = self.time + time
        while self.time < end:
            self._go(self._pose(), DWELL * self.random.uniform(0.2, 1.0))

    def _steps(self, time: float, poses: list[FloatArray]) -> None:
        """Step there and back within little time."""
        end, number, centre = self.time + time, 0, self.here
        while self.time < end or number % 2:
            duration = self._whole(STEP_TIMES[(number // 2) % len(STEP_TIMES)])
            size = STEP_SHARE * self.specification.intensity * self.scales.acceleration * duration**2 / 10.0
            if number % 2 == 0:
                signs = self.random.choice([-1.0, 1.0], len(centre))
            self._move(centre if number % 2 else centre + signs * size, ninth_degree(1.0, duration), 0.15)
            number += 1

    def _vibrate(self, vibration: Vibration) -> None:
        self._add(Move(vibration, vibration.law()))
