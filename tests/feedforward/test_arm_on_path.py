from __future__ import annotations

import numpy as np
import pytest

from flexros.feedforward.arm_on_path import FeedforwardOnPath
from flexros.feedforward.reference import compute_reference
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.robot import load_robot
from flexros.trajectory import Arc, JointMove, Line, Move, Trajectory, ninth_degree
from flexros.trajectory.path import AbstractPath

RIGID = FeedforwardSpecification(method="rigid", hold_compensation=False)
ELBOW = load_robot("elbow")


def on(output: str, method: FeedforwardSpecification = RIGID) -> FeedforwardOnPath:
    return FeedforwardOnPath(ELBOW, method, ELBOW.sample_time, output)


def arc() -> AbstractPath:
    start = ELBOW.forward_kinematics(ELBOW.home)
    return Arc.about(start + np.array([-0.1, 0.0]), start, 2.0)


@pytest.mark.parametrize("output", ["tool", "joints"])
def test_torque_on_the_path_is_that_of_the_rigid_arm(output: str) -> None:
    path = arc() if output == "tool" else JointMove(ELBOW.home, np.array([1.0, -0.4]))
    law = ninth_degree(path.extent, duration=0.9)
    reference = compute_reference(ELBOW, Trajectory((Move(path, law),), output), RIGID, ELBOW.sample_time, 0.9)
    dynamics = on(output).dynamics(path, None, 2001)
    share, pace, acceleration = law.evaluate(reference.time, 2) / path.extent

    def at(values: np.ndarray) -> np.ndarray:
        return np.column_stack([np.interp(share, dynamics.grid, column) for column in values.T])

    torque = (
        at(dynamics.inertia) * acceleration[:, None]
        + at(dynamics.centrifugal) * pace[:, None] ** 2
        + at(dynamics.viscous) * pace[:, None]
        + at(dynamics.static)
    )
    np.testing.assert_allclose(torque, reference.torque, atol=2e-4 * np.abs(reference.torque).max())


def test_limits_are_those_of_the_robot_file() -> None:
    dynamics = on("tool").dynamics(arc(), None, 11)
    np.testing.assert_array_equal(dynamics.upper[3], [3000.0, 2000.0])
    np.testing.assert_array_equal(dynamics.lower, -dynamics.upper)
    assert np.all(np.isinf(dynamics.speed_limit))


def test_end_of_a_tool_path_is_where_the_next_one_begins() -> None:
    path = arc()
    end = on("tool").end(path, None)
    np.testing.assert_allclose(ELBOW.forward_kinematics(end), path.end, atol=1e-9)
    onward = Line(path.end, path.end + np.array([0.05, 0.0]))
    np.testing.assert_allclose(on("tool").end(onward, end), end, atol=0.2)


def test_without_feedforward_the_rigid_arm_counts() -> None:
    path = arc()
    move = [Move(path, ninth_degree(path.extent, duration=0.9))]
    none, rigid = (on("tool", FeedforwardSpecification(method=name)).demand(move, None) for name in ("none", "rigid"))
    np.testing.assert_array_equal(none.torque, rigid.torque)
    assert np.abs(none.torque).max() > 100.0
