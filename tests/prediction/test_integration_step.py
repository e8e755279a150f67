"""Step of predictors: long for slow robots, short for fast ones and for effects with fast states."""

from __future__ import annotations

import pytest

from flexros.prediction.integration_step import substeps
from flexros.robot import load_robot


@pytest.mark.parametrize(
    ("name", "sample_time", "steps"), [("six_axis", 5e-4, 1), ("six_axis", 0.01, 20), ("emps", 0.01, 4)]
)
def test_the_fastest_motion_of_a_robot_decides(name: str, sample_time: float, steps: int) -> None:
    assert substeps(load_robot(name), sample_time) == steps


def test_effects_with_fast_states_get_at_most_five_steps_in_a_sample() -> None:
    assert substeps(load_robot("emps"), 2e-3, fast=True) == 4
    assert substeps(load_robot("emps"), 0.02, fast=True) == 5
