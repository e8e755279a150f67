"""One small study that all tests share: E12, three positions, few starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from flexros.identify.graybox.problem import graybox_problem
from flexros.robot.robot import load_robot
from flexros.scenario.identification import unknown_names
from flexros.validation.campaigns.study.jobs import Study, fitted_rows, study_jobs, study_of
from flexros.validation.campaigns.study.real_robot import measured_responses, study_scenario
from flexros.validation.campaigns.study.settings import StudySettings

if TYPE_CHECKING:
    from flexros.scenario.scenario import Scenario

SMALL = StudySettings("identify_e12", positions=3, candidates=40, starts=4, redrawn=30, seed=3)


@pytest.fixture(scope="session")
def small_scenario() -> Scenario:
    return study_scenario(SMALL)


@pytest.fixture(scope="session")
def small_study(small_scenario: Scenario) -> Study:
    robot = load_robot("e12")
    problem = graybox_problem(robot, measured_responses(small_scenario), unknown_names(robot))
    parts = {name: fitted_rows(problem, *arguments) for name, arguments in study_jobs(problem, SMALL).items()}
    return study_of(problem, parts, SMALL)
