from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot import Robot, load_robot
from flexros.trajectory import Trajectory
from tests.feedforward.cases import edited_robot, joint_trajectory, problem_of, tool_trajectory
from tests.oracles.index_one import output_drift, solve_index_one


@pytest.mark.slow
def test_exact_inverse_dynamics_of_the_smooth_case(e12: Robot, smooth: Trajectory) -> None:
    solution = solve_index_one(problem_of(e12, smooth, 0.1, 0.4), "LSODA", 1e-11, 1e-13)
    np.testing.assert_allclose(solution.arm_position[-1], [-0.11755577466, 0.52013162855, 0.00959511598], atol=3e-9)
    np.testing.assert_allclose(solution.motor_position[-1], [-0.10564743424, 0.51020347290], atol=3e-9)
    np.testing.assert_allclose(solution.torque[-1], [2535.627, -3724.009], atol=2e-3)


@pytest.mark.slow
def test_output_drifts(e12: Robot, smooth: Trajectory) -> None:
    problem = problem_of(e12, smooth, 0.01, 0.6)
    drift = [
        output_drift(e12, "tool", solve_index_one(problem, "LSODA", rtol, rtol).arm_position, problem.desired)
        for rtol in (1e-6, 1e-9)
    ]
    assert drift[0] > 1e-7  # time stepping of the DAE keeps 5e-15
    assert drift[1] < drift[0]


def test_needs_a_damper_at_every_gear(smooth: Trajectory) -> None:
    def undamp(data: dict[str, list[dict[str, dict[str, dict[str, object]]]]]) -> None:
        data["bodies"][0]["directions"]["ry"]["damper"] = 0
        data["bodies"][1]["directions"]["ry"]["damper"] = 0

    with pytest.raises(
        InputError, match=r"does not determine the torque: the index-1 form needs a damper at every gear"
    ):
        solve_index_one(problem_of(edited_robot("e12", undamp), smooth, 0.01, 0.1))


def test_needs_flexible_gears() -> None:
    emps = load_robot("emps")
    line = tool_trajectory(emps, {"type": "line", "end_from_start": [0.1]}, {"type": "ninth_degree", "duration": 0.5})
    with pytest.raises(InputError, match="needs a flexible gear at every motor"):
        solve_index_one(problem_of(emps, line, 0.01, 0.1))


def test_needs_the_path_in_the_controlled_output(e12: Robot) -> None:
    with pytest.raises(InputError, match=r"needs a trajectory of output 'tool' itself, but it is one of 'joints'"):
        solve_index_one(problem_of(e12, joint_trajectory(e12, [0.1, 0.1], 0.5), 0.01, 0.1))
