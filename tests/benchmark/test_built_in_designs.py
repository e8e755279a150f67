"""The built-in designs: costs and demands that the results page states, and the commands that made them."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.benchmark.controllers import controller_names, load_controller, read_made_by, read_parameters
from flexros.benchmark.evaluate import FeedbackBenchmark
from flexros.control.context import LoopContext
from flexros.control.design.margins import frequency_grid, loop_response
from flexros.control.design.methods.base import DesignProblem, design_methods
from flexros.control.linear_controller import linear_controller
from flexros.robot import load_robot

pytestmark = pytest.mark.slow

BY_HAND = {"pid_check", "pid_regulator"}


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [
        ("pid_optimised", 142.6, 144.6),
        ("lqg", 125.0, 128.0),
        ("pid_section_1", 128.0, 131.0),
        ("mu_synthesis", 138.0, 142.0),
        ("acceleration_3", 99.0, 105.0),
    ],
)
def test_design_has_its_cost_and_meets_all_demands(name: str, least: float, most: float) -> None:
    controller = load_controller(name)
    result = FeedbackBenchmark(controller.sensors).evaluate(controller)
    assert least < result.cost < most
    assert result.passed


@pytest.mark.parametrize("name", sorted(set(controller_names()) - BY_HAND))
def test_every_tuned_design_names_its_command(name: str) -> None:
    assert "flexros design " in read_made_by(name)


@pytest.mark.parametrize("name", ["mu_synthesis", "mixed_sensitivity"])
def test_command_of_a_direct_design_makes_the_file_again(name: str) -> None:
    pytest.importorskip("slycot")
    robot = load_robot("four_mass")
    problem = DesignProblem.of(robot)
    context = LoopContext(robot, robot.sample_time)
    frequency = frequency_grid(robot.sample_time)[::20]
    # badly conditioned: for a plant that is 1e-15 off the controller is another one, the loop the same within 0.3 %
    again, kept = (
        1 / (1 + loop_response(problem.sampled, linear_controller(law, context), frequency).loop)
        for law in (
            design_methods()[name](**read_parameters(name).get("nominal", {})).design(problem).law(),
            load_controller(name).nominal,
        )
    )
    assert np.abs(again - kept).max() < 0.01 * np.abs(kept).max()
