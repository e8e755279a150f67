"""Step of predictors: long for slow robots, short for fast ones and for effects with fast states."""

from __future__ import annotations

import pytest
import yaml

from flexros.prediction.integration_step import substeps
from flexros.robot import load_robot, robot_from_data


@pytest.mark.parametrize(
    ("name", "sample_time", "steps"),
    [("six_axis", 5e-4, 1), ("six_axis", 4e-3, 5), ("six_axis", 0.01, 11), ("emps", 0.01, 4)],
)
def test_the_fastest_motion_of_a_robot_decides(name: str, sample_time: float, steps: int) -> None:
    assert substeps(load_robot(name), sample_time) == steps


def test_effects_with_fast_states_get_at_most_five_steps_in_a_sample() -> None:
    assert substeps(load_robot("emps"), 2e-3, fast=True) == 4
    assert substeps(load_robot("emps"), 0.02, fast=True) == 5


def test_much_damping_on_little_inertia_needs_steps_that_do_not_grow() -> None:
    brake = "{spring: rigid, motor: {inertia: 1.0e-4, viscous_friction: 1.0}}"  # 1e4 1/s
    data = {"name": "brake", "bodies": [{"directions": {"ry": yaml.safe_load(brake)}}], "controlled": "j"}
    robot = robot_from_data({**data, "outputs": {"j": {"coordinates": ["body_1.ry"]}}}, "brake.yaml")
    assert substeps(robot, 0.004) == substeps(robot, 0.004, fast=True) == 16
