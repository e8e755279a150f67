"""Every way to estimate finds the truth from its random start."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.identify.graybox.search import SearchSettings
from flexros.robot import load_robot
from flexros.scenario.scenario import Scenario
from flexros.validation.campaigns.coverage.estimates import DEFAULT, WAYS, group_estimates
from flexros.validation.campaigns.coverage.settings import CoverageSettings, RepetitionGroup

pytestmark = pytest.mark.slow

NAMES = ("body_1.ry.stiffness", "body_2.ry.stiffness", "body_3.ry.stiffness")


@pytest.fixture(scope="module")
def estimates(short_experiment: Scenario) -> dict[str, Any]:
    return group_estimates(short_experiment, NAMES, CoverageSettings(start_factor=1.2), RepetitionGroup(0, 5, (70,)))


@pytest.mark.parametrize("way", [way.name for way in WAYS])
def test_truth_is_found_in_every_way(estimates: dict[str, Any], way: str) -> None:
    (row,) = estimates[way]
    truth = [load_robot("e12").parameters[name].value for name in NAMES]
    assert row["values"] == pytest.approx(truth, rel=0.01)
    assert row["verdicts"] == ["determined"] * 3
    assert row["converged"]
    assert np.all(np.array(row["deviations"]) > 0)


def test_default_is_that_of_an_identification() -> None:
    default = next(way for way in WAYS if way.name == DEFAULT)
    assert (default.estimator, default.weights) == (SearchSettings().estimator, SearchSettings().weights)


def test_one_way_each_name() -> None:
    assert len({way.name for way in WAYS}) == len(WAYS)
