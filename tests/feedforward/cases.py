"""Robots, trajectories and problems that the tests of the feedforward share."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from flexros.arrays import FloatArray
from flexros.config.settings import validate
from flexros.config.yaml_file import read_yaml
from flexros.feedforward.problem import FeedforwardProblem
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.robot import Robot, load_robot, robot_from_data
from flexros.robot.robot import LIBRARY
from flexros.trajectory import Trajectory, TrajectorySpecification, build_trajectory

CIRCLE = {"type": "circle", "centre_from_start": [-0.025, 0]}
CENTRE = np.array([2.146403786951 - 0.025, -0.354624247994])
SMOOTH = {"type": "ninth_degree", "duration": 0.8}
BANG_BANG = {"type": "bang_bang_snap", "limits_of": "angle", "speed": 20, "acceleration": 600, "snap": 2.16e6}


def tool_trajectory(robot: Robot, path: Mapping[str, Any], law: Mapping[str, Any], output: str = "tool") -> Trajectory:
    start = robot.forward_kinematics(robot.home, output)
    return build_trajectory(
        validate(TrajectorySpecification, {"path": path, "time_law": law}, "test"), start, output=output
    )


def joint_trajectory(robot: Robot, change: list[float], duration: float) -> Trajectory:
    data = {
        "path": {"type": "joint_moves", "points_from_start": [change]},
        "time_law": {"type": "ninth_degree", "duration": duration},
    }
    return build_trajectory(validate(TrajectorySpecification, data, "test"), robot.home[list(robot.gear_rows)])


def edited_robot(name: str, change: Callable[[dict[str, Any]], None]) -> Robot:
    """Change the file of a built-in robot."""
    data = copy.deepcopy(read_yaml(LIBRARY / f"{name}.yaml"))
    change(data)
    return robot_from_data(data, "test robot")


def subdivided_e12(pieces: int, stiffness: float = 2e8) -> Robot:
    """Cut every body of E12 into pieces joined by stiff springs [Nm/rad] (chosen); gears and spring 3 stay."""
    bodies: list[dict[str, Any]] = []
    for body in load_robot("e12").spec.bodies:
        length, centre = body.length.value[0] / pieces, body.center_of_mass.value[0] - body.length.value[0] / 2
        for piece in range(pieces):
            first = body.directions["ry"].model_dump(exclude_none=True)
            bodies.append(
                {
                    "mass": body.mass.value / pieces,
                    "center_of_mass": [length / 2 + centre, 0, 0],
                    "inertia": {"yy": body.inertia.yy.value / pieces},
                    "length": [length, 0, 0],
                    "directions": {"ry": {"spring": stiffness, "damper": 5e-4 * stiffness} if piece else first},
                }
            )
    home = [0.0] * len(bodies)
    home[pieces] = 0.3
    outputs = {"tool": {"pose": ["x", "z"]}, "joints": {"coordinates": ["body_1.ry", f"body_{pieces + 1}.ry"]}}
    data = {"name": "e12_fine", "bodies": bodies, "outputs": outputs, "controlled": "tool", "home": home}
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
