"""Robots, trajectories and problems that the tests of the feedforward share."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from flexros.arrays import FloatArray
from flexros.config.yaml_file import read_yaml
from flexros.feedforward.problem import FeedforwardProblem
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.robot import Robot, robot_from_data
from flexros.robot.robot import LIBRARY
from flexros.trajectory import Trajectory, build_trajectory, read_trajectory

CIRCLE = {"type": "circle", "centre_from_start": [-0.025, 0]}
CENTRE = np.array([2.146403786951 - 0.025, -0.354624247994])
SMOOTH = {"type": "ninth_degree", "duration": 0.8}
BANG_BANG = {"type": "bang_bang_snap", "limits_of": "angle", "speed": 20, "acceleration": 600, "snap": 2.16e6}


def tool_trajectory(robot: Robot, path: Mapping[str, Any], law: Mapping[str, Any], output: str = "tool") -> Trajectory:
    start = robot.forward_kinematics(robot.home, output)
    return build_trajectory(read_trajectory({"path": path, "time_law": law}, "test"), start, output=output)


def joint_trajectory(robot: Robot, change: list[float], duration: float) -> Trajectory:
    data = {
        "path": {"type": "joint_moves", "points_from_start": [change]},
        "time_law": {"type": "ninth_degree", "duration": duration},
    }
    return build_trajectory(read_trajectory(data, "test"), robot.home[list(robot.chain.geared)])


def edited_robot(name: str, change: Callable[[dict[str, Any]], None]) -> Robot:
    """Change the file of a shipped robot."""
    data = copy.deepcopy(read_yaml(LIBRARY / f"{name}.yaml"))
    change(data)
    return robot_from_data(data, "test robot")


def problem_of(
    robot: Robot, trajectory: Trajectory, sample_time: float, duration: float, **settings: Any
) -> FeedforwardProblem:
    n_samples = round(duration / sample_time) + 1
    return FeedforwardProblem(robot, trajectory, FeedforwardSpecification(**settings), sample_time, n_samples)


def smooth_circle(t: FloatArray) -> FloatArray:
    """The smooth case of the facts, written out independently of the trajectory room."""
    s = np.clip(t / 0.8, 0.0, 1.0)
    Q = 2 * np.pi * (126 * s**5 - 420 * s**6 + 540 * s**7 - 315 * s**8 + 70 * s**9)
    return CENTRE + 0.025 * np.stack([np.cos(Q), np.sin(Q)], axis=-1)
