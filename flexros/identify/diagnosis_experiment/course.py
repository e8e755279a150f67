"""The course of a diagnosis experiment: its parts in the order of time, as one trajectory of the gears."""

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
"""Number of the random stream of the experiment among those of excitations."""
FIRST_REST = 1.2
"""Rest at the start [s] (chosen)."""
LAST_REST = 0.5
"""Rest at the end [s] (chosen)."""
WAY_BACK = 1.0
"""Time set aside for the way back to the start [s] (chosen)."""
SHORTEST_PART = 0.3
"""Shortest time of a part [s] (chosen)."""


@dataclass(frozen=True)
class Part:
    """A part of the experiment.

    Attributes:
        name: What it is, e.g. "creep", or "standstill".
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
        parts: Its parts in the order of time; between them lie the fast moves from pose to pose.
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

    It rests, carries out the parts in random order, pose after pose, moves fast from one pose to the next, returns to
    the start and rests. The time of a part is its share of the length, the way to its pose included.

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
    sequence = Sequence(specification, vibrations, random, arm[list(robot.gear_rows)])
    order = [specification.parts[index] for index in random.permutation(len(specification.parts))]
    unit = specification.length - FIRST_REST - LAST_REST - WAY_BACK
    unit /= sum(WEIGHTS[name] for name in order)
    sequence.stay(FIRST_REST)
    parts = [Part("standstill", 0.0, sequence.time)]
    for number, name in enumerate(order):
        due = sequence.time + unit * WEIGHTS[name]
        sequence.go(sequence.poses[number % len(sequence.poses)])
        begin = sequence.time
        PARTS[name](sequence, max(due - begin, SHORTEST_PART))
        parts.append(Part(name, begin, sequence.time))
    sequence.go(sequence.start)
    begin = sequence.time
    sequence.stay(LAST_REST)
    parts.append(Part("standstill", begin, sequence.time))
    return Course(Trajectory(tuple(sequence.moves), JOINTS), tuple(parts), scales)
