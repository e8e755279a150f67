"""Course of a diagnosis experiment: its parts in order of time, as one trajectory of the gears."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.identify.diagnosis_experiment.parts import PARTS
from flexros.identify.diagnosis_experiment.scales import Scales, scales_of
from flexros.identify.diagnosis_experiment.sequence import Sequence
from flexros.identify.diagnosis_experiment.specification import WEIGHTS
from flexros.identify.diagnosis_experiment.vibrations import Vibrations
from flexros.random_streams import Stream, generator
from flexros.trajectory import JOINTS, Trajectory

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.identify.diagnosis_experiment.specification import DiagnosisSpecification
    from flexros.robot import Robot

PARTS_STREAM = 2
"""Index of the random stream of the experiment among those of excitations."""
FIRST_REST = 1.2
"""Rest at the beginning [s] (chosen)."""
LAST_REST = 0.5
"""Rest at the end [s] (chosen)."""
RETURN_TIME = 1.0
"""Time reserved for the return to the initial pose [s] (chosen)."""
SHORTEST_PART = 0.3
"""Shortest time of a part [s] (chosen)."""


@dataclass(frozen=True)
class Part:
    """A part of the experiment.

    Attributes:
        name: Name, e.g. "creep", or "standstill".
        begin: Initial time [s].
        end: Final time [s].
    """

    name: str
    begin: float
    end: float


@dataclass(frozen=True, eq=False)
class Course:
    """Schedule and motion of the experiment.

    Attributes:
        trajectory: Gear motion; every move takes whole samples.
        parts: Its parts in order of time; the fast moves from pose to pose are between them.
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
    """Compute the diagnosis experiment of a robot; it depends on these arguments alone.

    It rests, carries out the parts in random order, pose after pose, with fast moves between the poses, returns to the
    initial pose and rests. The time of a part is its share of the length, including the move to its pose.

    Args:
        specification: Length, parts and sizes.
        robot: The nominal robot.
        law: The feedback controller.
        sample_time: Time between two samples [s].
        seed: Seed if the specification has none.
        arm: Initial arm coordinates [rad or m], shape (N,).

    Raises:
        InputError: Settings and robot are incompatible.
    """
    chosen_seed = seed if specification.seed is None else specification.seed
    random = generator(chosen_seed, Stream.EXCITATION, PARTS_STREAM)
    scales = scales_of(specification, robot, arm)
    vibrations = Vibrations(robot, arm, law, sample_time, scales)
    sequence = Sequence(specification, vibrations, random, arm[list(robot.gear_rows)])
    order = [specification.parts[index] for index in random.permutation(len(specification.parts))]
    unit = specification.length - FIRST_REST - LAST_REST - RETURN_TIME
    unit /= sum(WEIGHTS[name] for name in order)
    sequence.stay(FIRST_REST)
    parts = [Part("standstill", 0.0, sequence.time)]
    for index, name in enumerate(order):
        due = sequence.time + unit * WEIGHTS[name]
        sequence.go(sequence.poses[index % len(sequence.poses)])
        begin = sequence.time
        PARTS[name](sequence, max(due - begin, SHORTEST_PART))
        parts.append(Part(name, begin, sequence.time))
    sequence.go(sequence.start)
    begin = sequence.time
    sequence.stay(LAST_REST)
    parts.append(Part("standstill", begin, sequence.time))
    return Course(Trajectory(tuple(sequence.moves), JOINTS), tuple(parts), scales)
