"""Repetitions side by side give the responses of the whole experiment."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.identify.frf.positions import estimate_responses
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.scenario import Scenario, load_scenario
from flexros.validation.campaigns.coverage.experiment import group_responses, repeated_scenario
from flexros.validation.campaigns.coverage.settings import CoverageSettings, RepetitionGroup

pytestmark = pytest.mark.slow

Responses = list[tuple[FrequencyResponse, ...]]


@pytest.fixture(scope="module")
def repetitions(short_experiment: Scenario) -> Responses:
    return group_responses(short_experiment, RepetitionGroup(0, 5, (70, 71)))


def test_every_repetition_has_all_positions(repetitions: Responses) -> None:
    assert [[row.gears.tolist() for row in rows] for rows in repetitions] == [[[0.0, 0.3], [0.3, 1.0]]] * 2


def test_noise_differs_between_repetitions(repetitions: Responses) -> None:
    first, second = (rows[1].response for rows in repetitions)
    assert 0 < np.median(np.abs(first / second - 1)) < 1e-2


def test_responses_are_those_of_the_whole_experiment(short_experiment: Scenario, repetitions: Responses) -> None:
    scenario = short_experiment.with_values({"seed": 5, "noise": True})
    whole = estimate_responses(closed_loop(Experiment.prepare(scenario)), plan_of_scenario(scenario))
    for one, other in zip(repetitions[0], whole, strict=True):
        assert np.array_equal(one.frequency, other.frequency)
        deviation = np.hypot(one.standard_deviation("noise"), other.standard_deviation("noise"))
        assert np.median(np.abs(one.response - other.response) / deviation) < 2


def test_positions_are_designed(short_experiment: Scenario) -> None:
    settings = CoverageSettings(scenario="identify_e12", positions=3, candidates=30)
    scenario = repeated_scenario(load_scenario("identify_e12"), settings)
    assert scenario.identification is not None
    assert len(scenario.identification.positions) == 3
