"""One small study that all tests share: E12, three positions, few starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from flexros.identify.study.campaign import Study, run_study
from flexros.identify.study.real_robot import measured_responses, study_scenario, unknowns
from flexros.robot.robot import load_robot

if TYPE_CHECKING:
    from flexros.config.scenario import Scenario


@pytest.fixture(scope="session")
def small_scenario() -> Scenario:
    return study_scenario("identify_e12", positions=3, blocks=2, seed=3, candidates=40)


@pytest.fixture(scope="session")
def small_study(small_scenario: Scenario) -> Study:
    robot = load_robot("e12")
    responses = measured_responses(small_scenario)
    return run_study(robot, responses, unknowns(robot), starts=6, seed=3, redrawn=30, threads=2)
