"""State feedback with an estimator: the separation of their poles."""

from __future__ import annotations

import numpy as np

from flexros.control.context import LoopContext
from flexros.control.design.closed_loop import closed_loops
from flexros.control.design.estimator import disturbance_plant, estimator_controller
from flexros.control.design.methods.base import Design, DesignProblem
from flexros.control.linear_controller import linear_controller
from flexros.robot import load_robot


def test_closed_loop_has_the_poles_of_regulator_and_estimator() -> None:
    robot = load_robot("two_mass")
    problem = DesignProblem.of(robot, delay=7e-4)
    plant = problem.sampled
    A, B, C = disturbance_plant(plant)
    rng = np.random.default_rng(1)
    n = plant.A.shape[-1]
    feedback = np.hstack([1e-2 * rng.normal(size=(1, n)), [[1.0]]])
    gain = 1e-2 * rng.normal(size=(n + 1, 1))
    system = estimator_controller(A, B, C, feedback, gain)
    law = Design(system, problem.sample_time, None, {}).law()
    loop = closed_loops(plant, linear_controller(law, LoopContext(robot, problem.sample_time)))[0]
    regulator = np.linalg.eigvals(plant.A[0] - plant.B[0] @ feedback[:, :n])
    estimator = np.linalg.eigvals((np.eye(n + 1) - gain @ C) @ A)
    wanted = np.concatenate([regulator, estimator])
    found = np.linalg.eigvals(loop)
    assert len(found) == len(wanted)
    for pole in wanted:
        assert np.min(np.abs(found - pole)) < 1e-5


def test_constant_disturbance_torque_leaves_no_error() -> None:
    robot = load_robot("two_mass")
    problem = DesignProblem.of(robot)
    plant = problem.sampled
    from flexros.control.design.methods.lqg import Lqg

    law = Lqg().design(problem).law()
    linear = linear_controller(law, LoopContext(robot, problem.sample_time))
    loop = closed_loops(plant, linear)[0]
    entry = np.concatenate([plant.G[0][:, 0], np.zeros(len(loop) - plant.A.shape[-1])])
    rest = np.linalg.solve(np.eye(len(loop)) - loop, entry)
    open_rest = abs(plant.F[0, 0] @ rest[: plant.A.shape[-1]])
    assert np.max(np.abs(np.linalg.eigvals(loop))) < 1.0
    assert open_rest < 1e-9
