"""The built-in designs: costs and demands that the results page states, and the commands that made them."""

from __future__ import annotations

import dataclasses

import pytest

from flexros.benchmark.controllers import controller_names, load_controller, read_made_by, read_parameters
from flexros.benchmark.evaluate import FeedbackBenchmark
from flexros.control.design.methods.base import DesignProblem, design_methods
from flexros.robot import load_robot

pytestmark = pytest.mark.slow

BY_HAND = {"pid_check", "pid_regulator"}


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [
        ("pid_optimised", 142.6, 144.6),
        ("lqg", 125.0, 128.0),
        ("pid_section_1", 128.0, 131.0),
        ("mu_synthesis", 142.0, 145.0),
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
def test_command_of_a_direct_design_makes_it_again(name: str) -> None:
    pytest.importorskip("slycot")
    problem, method, kept = DesignProblem.of(load_robot("four_mass")), design_methods()[name], load_controller(name)
    numbers = read_parameters(name) or {"nominal": {}}
    laws = {part: method(**values).design(problem).law() for part, values in numbers.items()}
    again = dataclasses.replace(kept, **{"perturbed": laws["nominal"], **laws})
    benchmark = FeedbackBenchmark(kept.sensors)
    # D-K iteration: rounding errors move the controller of mu_synthesis by some percent, its cost by 0.8 %
    assert benchmark.evaluate(again).cost == pytest.approx(benchmark.evaluate(kept).cost, rel=0.02)
