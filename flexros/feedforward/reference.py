"""References from method, friction, effects, hold and tool pose; at once or in chunks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.feedforward.base import feedforward_method
from flexros.feedforward.compensation.compensation import compensated, laws_of_the_arm, motor_delays
from flexros.feedforward.compensation.friction import friction_torque
from flexros.feedforward.dae import DaeFeedforward
from flexros.feedforward.hold import held_torque, samples_ahead
from flexros.feedforward.minimum_phase import actuation_time
from flexros.feedforward.motion import Motion, Reference
from flexros.feedforward.problem import FeedforwardProblem
from flexros.feedforward.stable_inversion import StableInversion, inverts_stably

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import PlacedLaw
    from flexros.feedforward.specification import FeedforwardSpecification
    from flexros.robot import Robot
    from flexros.trajectory.trajectory import Trajectory


def compute_reference(
    robot: Robot,
    trajectory: Trajectory,
    specification: FeedforwardSpecification,
    sample_time: float,
    duration: float,
    near: FloatArray | None = None,
    laws: Sequence[PlacedLaw] = (),
    *,
    link_motion: bool = False,
) -> Reference:
    """Compute references and feedforward torques of all samples.

    Args:
        robot: The model that the feedforward uses.
        trajectory: Desired motion; after its end the last point is held.
        specification: Method and its settings.
        sample_time: Sample time T of the feedback [s].
        duration: Time to cover [s]; the samples are 0, T, 2 T, ... up to and including `duration`.
        near: Arm coordinates near which the initial pose is sought [rad or m], shape (N,); default: the home pose.
        laws: Laws of effects to compensate, see `flexros.feedforward.compensation.compensation`.
        link_motion: Whether the motion of the links is needed too.

    Returns:
        The reference, floor(duration / T) + 1 samples.

    Raises:
        InputError: Settings, trajectory and robot are inconsistent.
        RunError: The method aborted at a sample.
    """
    chunks = reference_chunks(
        robot, trajectory, specification, sample_time, duration, near=near, laws=laws, link_motion=link_motion
    )
    return Reference.concatenate(list(chunks))


def pre_actuation(
    robot: Robot,
    trajectory: Trajectory,
    specification: FeedforwardSpecification,
    sample_time: float,
    near: FloatArray | None = None,
    laws: Sequence[PlacedLaw] = (),
) -> float:
    """Return the time for which the trajectory must rest at its start, so that the motors can move before the tool.

    Args:
        robot: The model that the feedforward uses.
        trajectory: Desired motion.
        specification: Method and its settings.
        sample_time: Sample time of the feedback [s].
        near: Arm coordinates near which the initial pose is sought [rad or m], shape (N,); default: the home pose.
        laws: Laws of effects to compensate.

    Returns:
        Whole samples of rest [s]; 0 for methods and paths without stable inversion.

    Raises:
        InputError: The output cannot be inverted, or the time would be too long.
    """
    if specification.method not in (DaeFeedforward.name, StableInversion.name):
        return 0.0
    n_samples = int(trajectory.duration / sample_time) + 1
    arm_laws = laws_of_the_arm(laws)
    problem = FeedforwardProblem(robot, trajectory, specification, sample_time, n_samples, near, arm_laws)
    problem.require_square(problem.output)
    if not inverts_stably(problem):
        return 0.0
    return float(np.ceil(actuation_time(problem) / sample_time)) * sample_time


def reference_chunks(
    robot: Robot,
    trajectory: Trajectory,
    specification: FeedforwardSpecification,
    sample_time: float,
    duration: float,
    chunk: int = 4096,
    near: FloatArray | None = None,
    laws: Sequence[PlacedLaw] = (),
    *,
    link_motion: bool = False,
) -> Iterator[Reference]:
    """Compute references chunk by chunk, for streaming; joined they equal `compute_reference` bit for bit.

    Args:
        robot: The model that the feedforward uses.
        trajectory: Desired motion; after its end the last point is held.
        specification: Method and its settings.
        sample_time: Sample time T of the feedback [s].
        duration: Time to cover [s].
        chunk: Largest number of samples per chunk.
        near: Arm coordinates near which the initial pose is sought [rad or m], shape (N,); default: the home pose.
        laws: Laws of effects to compensate, see `flexros.feedforward.compensation.compensation`.
        link_motion: Whether the motion of the links is needed too.

    Yields:
        Successive parts of the reference.

    Raises:
        InputError: Settings, trajectory and robot are inconsistent.
        RunError: The method aborted at a sample.
    """
    if not sample_time > 0.0:
        raise InputError(f"the sample time of the feedforward is {sample_time:g} s, but must be positive")
    if not duration >= 0.0:
        raise InputError(f"the duration of the feedforward is {duration:g} s, but must not be negative")
    if chunk < 1:
        raise InputError(f"the chunk of the feedforward is {chunk} samples, but must be at least 1")
    n_samples = int(np.floor(duration / sample_time + 1e-6)) + 1
    method = feedforward_method(specification.method)
    hold = specification.hold_compensation
    hold = method.compensates_hold(specification) if hold is None else hold
    delays = motor_delays(robot, laws)
    ahead = samples_ahead(sample_time, max(delays)) if hold else 0
    arm_laws = laws_of_the_arm(laws)
    problem = FeedforwardProblem(robot, trajectory, specification, sample_time, n_samples + ahead, near, arm_laws)
    motions = _with_friction(method.motions(problem, chunk), specification)
    if laws and specification.method != "none":
        motions = compensated(Motion.concatenate(list(motions)), robot, laws, sample_time).chunks(chunk)
    links = problem.gear_motion(4).swapaxes(0, 1) if link_motion else np.zeros((n_samples + ahead, 0, 0))
    done = 0
    for motion, n in _with_samples_ahead(motions, ahead):
        now, rows = motion.rows(0, n), slice(done, done + n)
        yield Reference(
            time=problem.time[rows],
            motor_position=now.motor_position,
            motor_velocity=now.motor_velocity,
            torque=_held(motion, n, sample_time, delays) if hold else now.torque,
            output=problem.desired[rows],
            tool_pose=problem.commanded_pose[rows],
            link_motion=links[rows],
        )
        done += n


def _held(motion: Motion, n: int, sample_time: float, delays: tuple[float, ...]) -> FloatArray:
    """Compute the mean torque while a command acts, with the delay of each motor, shape (n, M)."""
    torque = np.empty((n, len(delays)))
    for motor, delay in enumerate(delays):
        rows, column = slice(0, n + samples_ahead(sample_time, delay)), slice(motor, motor + 1)
        torque[:, column] = held_torque(motion.load[rows, column], motion.momentum[rows, column], sample_time, delay)
    return torque


def _with_friction(motions: Iterator[Motion], specification: FeedforwardSpecification) -> Iterator[Motion]:
    """Add the friction torque of the settings."""
    for motion in motions:
        if specification.friction is None:
            yield motion
        else:
            yield motion.with_friction(friction_torque(specification.friction, motion.motor_velocity))


def _with_samples_ahead(motions: Iterator[Motion], ahead: int) -> Iterator[tuple[Motion, int]]:
    """Yield each part of the motion with `ahead` samples beyond it, and its length without them."""
    waiting: Motion | None = None
    for part in motions:
        motion = part if waiting is None else waiting.joined(part)
        ready = max(0, len(motion) - ahead)
        if ready:
            yield motion, ready
        waiting = motion.rows(ready, len(motion))
