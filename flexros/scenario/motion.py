"""The desired motion of a scenario, and the fastest one on the same path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError, source_named
from flexros.feedforward.arm_on_path import FeedforwardOnPath
from flexros.identify.diagnosis_experiment.course import diagnosis_course
from flexros.scenario.models import ScenarioModels
from flexros.trajectory import JOINTS, Trajectory, build_trajectory
from flexros.trajectory.time_optimal.specification import TimeOptimalSpecification

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.scenario.scenario import Scenario
    from flexros.trajectory import TrajectorySpecification
    from flexros.trajectory.time_optimal.planner import OptimalMove


def planned_trajectory(scenario: Scenario, models: ScenarioModels, source: str, sample_time: float) -> Trajectory:
    """Plan the motion of a scenario without identification from its start pose.

    Args:
        scenario: The scenario.
        models: Its robots.
        source: Source of the scenario; error messages begin with it.
        sample_time: Sample time of the feedback [s].

    Returns:
        The motion; a rest if the scenario has none.

    Raises:
        InputError: Invalid start, impossible geometry, or limits that cannot be met.
    """
    robot, near = models.nominal.robot, _start(scenario, models, source)
    if scenario.diagnosis is not None:
        with source_named(source):
            return diagnosis_course(
                scenario.diagnosis, robot, scenario.controller, sample_time, scenario.seed, near
            ).trajectory
    if scenario.trajectory is None:
        return Trajectory.at_rest(near[list(robot.gear_rows)])
    begin = _Begin.of(scenario, scenario.trajectory, models, source, near, sample_time)
    return build_trajectory(
        scenario.trajectory,
        begin.coordinates,
        output=begin.arm.output,
        n_position=begin.n_position,
        arm=begin.arm,
        source=f"{source}, key trajectory",
    )


def fastest_moves(scenario: Scenario) -> list[OptimalMove]:
    """Plan the time-optimal moves on the path of a scenario, each from rest to rest.

    Args:
        scenario: The scenario; the keys of a time law time_optimal apply, another law counts as one with default keys.

    Returns:
        One move for each path between two stops, and back where the scenario returns.

    Raises:
        InputError: The scenario has no path, or the robot has no limits.
    """
    source = f"scenario {scenario.name}"
    specification = scenario.trajectory
    if specification is None:
        raise InputError(
            f"{source} has no trajectory, so there is no path to travel; choose a scenario with the key trajectory"
        )
    models = ScenarioModels.of(scenario)
    sample_time = models.nominal.robot.sample_time if scenario.sample_time is None else scenario.sample_time
    near = _start(scenario, models, source)
    begin = _Begin.of(scenario, specification, models, source, near, sample_time)
    law = specification.time_law
    law = law if isinstance(law, TimeOptimalSpecification) else TimeOptimalSpecification(type="time_optimal")
    with source_named(f"{source}, key trajectory"):
        n_position = min(3, begin.coordinates.size) if begin.n_position is None else begin.n_position
        paths = specification.path.paths(begin.coordinates, n_position)
        return law.plan(paths, begin.arm, return_to_start=specification.return_to_start)


@dataclass(frozen=True, eq=False)
class _Begin:
    """Where a trajectory begins, in its own coordinates, and the arm that it is for."""

    coordinates: FloatArray
    n_position: int | None
    arm: FeedforwardOnPath

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        specification: TrajectorySpecification,
        models: ScenarioModels,
        source: str,
        near: FloatArray,
        sample_time: float,
    ) -> _Begin:
        robot, known = models.nominal.robot, models.known
        output = specification.output_of(scenario.feedforward.output or robot.controlled)
        arm = FeedforwardOnPath(known.robot, scenario.feedforward, sample_time, output, near, known.laws)
        if output == JOINTS:
            return cls(near[list(robot.gear_rows)], None, arm)
        key = "trajectory.output" if specification.output else "feedforward.output"
        with source_named(f"{source}, key {key}"):
            coordinates = robot.forward_kinematics(near, output)
        pose = robot.spec.outputs[output].pose
        n_position = len([component for component in pose if component in ("x", "y", "z")])
        return cls(coordinates, n_position or None, arm)


def _start(scenario: Scenario, models: ScenarioModels, source: str) -> FloatArray:
    """Return the arm coordinates at the start [rad or m], shape (N,)."""
    robot = models.nominal.robot
    if scenario.start is None:
        return robot.home
    with source_named(f"{source}, key start"):
        return np.asarray(robot.check_arm(scenario.start))
